#include "services/dashboard/gateway/pages.hpp"

#include <fstream>
#include <gmock/gmock.h>

#include "services/dashboard/gateway/http_api.hpp"
#include "services/dashboard/gateway/server.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::dashboard {
namespace {

using ::testing::HasSubstr;

class PagesTest : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) {
    std::filesystem::create_directories((folder_.path() / name).parent_path());
    std::ofstream(folder_.path() / name) << text;
  }
  testing::TemporaryFolder folder_;
};

TEST_F(PagesTest, AreFoundByPathWithOrWithoutTheirEnding) {
  write("index.html", "operator");
  write("results.html", "results");
  write("assets/a-123.js", "code");
  const auto pages = Pages::load(folder_.path());
  ASSERT_TRUE(pages) << pages.error().message;
  EXPECT_EQ(pages->find("/")->content, "operator");
  EXPECT_EQ(pages->find("/results")->content, "results");
  EXPECT_EQ(pages->find("/results")->type, "text/html; charset=utf-8");
  EXPECT_TRUE(pages->find("/assets/a-123.js")->is_named_by_content);
  EXPECT_FALSE(pages->find("/")->is_named_by_content);
}

TEST_F(PagesTest, AFolderIsAddedBelowItsPrefix) {
  write("pages/index.html", "operator");
  write("manual/index.html", "manual");
  write("manual/figures/a.svg", "picture");
  auto pages = Pages::load(folder_.path() / "pages");
  ASSERT_TRUE(pages);
  ASSERT_TRUE(pages->add(folder_.path() / "manual", "/manual"));
  EXPECT_EQ(pages->find("/")->content, "operator");
  EXPECT_EQ(pages->find("/manual/")->content, "manual");
  EXPECT_EQ(pages->find("/manual/index")->content, "manual");
  EXPECT_EQ(pages->find("/manual/figures/a.svg")->type, "image/svg+xml");
  EXPECT_EQ(pages->find("/manual"), nullptr) << "the server leads to /manual/, so that relative links hold";
  EXPECT_FALSE(pages->add(folder_.path() / "none", "/none"));
}

TEST_F(PagesTest, NothingElseIsFound) {
  write("index.html", "operator");
  const auto pages = Pages::load(folder_.path());
  ASSERT_TRUE(pages);
  for (const char* path : {"", "/x", "/../index.html", "/./index.html", "//index.html", "/assets"})
    EXPECT_EQ(pages->find(path), nullptr) << path;
}

TEST_F(PagesTest, ACompressedFileIsAFormOfItsPageAndNoPageOfItsOwn) {
  write("index.html", "operator");
  write("assets/a.js", "a long, long script");
  write("assets/a.js.br", "br");
  write("assets/a.js.gz", "gzip");
  write("alone.gz", "a file as any other");
  const auto pages = Pages::load(folder_.path());
  ASSERT_TRUE(pages) << pages.error().message;
  EXPECT_EQ(pages->size(), 3U);
  EXPECT_EQ(pages->find("/assets/a.js.br"), nullptr);
  EXPECT_EQ(pages->find("/assets/a.js.gz"), nullptr);
  EXPECT_EQ(pages->find("/alone.gz")->content, "a file as any other");
  const Page* script = pages->find("/assets/a.js");
  ASSERT_NE(script, nullptr);
  EXPECT_EQ(script->content, "a long, long script");
  EXPECT_EQ(representation(*script, "gzip, br").body, "br");
}

TEST(Representation, IsTheSmallestThatTheClientTakes) {
  Page page;
  page.content = "0123456789";
  page.gzip = "01234";
  page.brotli = "0123";
  const auto coding = [&page](const char* header) { return representation(page, header).coding; };
  EXPECT_EQ(coding("gzip, deflate, br"), "br");
  EXPECT_EQ(coding("br;q=0.1, gzip;q=1.0"), "br") << "both are welcome";
  EXPECT_EQ(coding("gzip, deflate"), "gzip");
  EXPECT_EQ(coding("GZIP"), "gzip");
  EXPECT_EQ(coding("*"), "br");
  EXPECT_EQ(coding("br;q=0, *"), "gzip");
  EXPECT_EQ(coding("gzip;q=0.5, br ; q=0.000"), "gzip");
  for (const char* header :
       {"", "identity", "deflate", "gzip;q=0, br;q=0", "*;q=0", "gzipped", "xbr", ",;=", "\xff"})
    EXPECT_EQ(coding(header), "") << header;
  EXPECT_EQ(representation(page, "").body, page.content);
}

TEST(Representation, IsThePageItselfWhereNothingIsSmaller) {
  Page page;
  page.content = "0123";
  EXPECT_EQ(representation(page, "gzip, br").body, page.content);
  page.gzip = "a longer one";
  EXPECT_EQ(representation(page, "gzip, br").coding, "");
}

TEST_F(PagesTest, AFolderWithoutPagesIsAnErrorThatNamesIt) {
  const auto pages = Pages::load(folder_.path());
  ASSERT_FALSE(pages);
  EXPECT_THAT(pages.error().message, HasSubstr(folder_.path().string()));
}

TEST_F(PagesTest, ReportsAreGivenOutFromTheirFolderOnly) {
  write("secret.html", "secret");
  write("reports/study/index.html", "report");
  std::filesystem::create_symlink(folder_.path() / "secret.html", folder_.path() / "reports" / "link.html");
  const ApiFolders folders{"", "", folder_.path() / "reports"};
  EXPECT_EQ(answer_api(folders, "/reports/study/index.html", "").body, "report");
  EXPECT_THAT(answer_api(folders, "/api/reports", "").body, HasSubstr("study/index.html"));
  for (const char* path :
       {"/reports/../secret.html", "/reports//etc/passwd", "/reports/study/../../secret.html",
        "/reports/link.html", "/reports/", "/reports/study", "/reports/none"})
    EXPECT_EQ(answer_api(folders, path, "").status, 404) << path;
}

TEST_F(PagesTest, AnArchiveThatIsNotThereIsSaidPlainly) {
  const ApiFolders folders{(folder_ / "none.sqlite").string(), "", ""};
  const auto answer = answer_api(folders, "/api/sessions", "");
  EXPECT_NE(answer.status, 200);
  EXPECT_THAT(answer.body, HasSubstr("none.sqlite"));
}

TEST(ListenAddress, IsAddressAndPort) {
  EXPECT_EQ(parse_listen("8765")->address, "127.0.0.1");
  EXPECT_EQ(parse_listen("10.0.0.1:80")->port, 80);
  EXPECT_EQ(parse_listen("[::1]:0")->address, "::1");
  for (const char* text : {"", "x", "1.2.3.4:", "1.2.3.4:65536", "1.2.3.4:-1", "1.2.3.4:8x"})
    EXPECT_FALSE(parse_listen(text)) << text;
}

}  // namespace
}  // namespace tonus::dashboard
