#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/integration/program_run.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::chrono::seconds kLimit{60};

/// A domain in which nothing but an archive runs.
class StatusOfAnArchiveAlone : public ::testing::Test {
 protected:
  void SetUp() override {
    archive_ = std::make_unique<Process>(
        program("tonus-archive"),
        std::vector<std::string>{"--domain", domain_, "--data", (folder_ / "data").string()},
        folder_ / "archive.log");
    ASSERT_TRUE(archive_->wait_for_output("store '", kLimit)) << archive_->output();
  }

  /// `status` is asked until it has heard the archive.
  [[nodiscard]] ProgramRun ask(std::vector<std::string> words) const {
    words.insert(words.end(), {"--domain", domain_});
    const auto deadline = std::chrono::steady_clock::now() + kLimit;
    ProgramRun run = run_program("tonus", words, folder_.path());
    while (run.code != 0 && words.front() == "status" && std::chrono::steady_clock::now() < deadline)
      run = run_program("tonus", words, folder_.path());
    return run;
  }

  const std::string domain_ = std::to_string(own_domain());
  TemporaryFolder folder_;
  std::unique_ptr<Process> archive_;
};

TEST_F(StatusOfAnArchiveAlone, NamesTheServicesThatWereNotHeardAndDoesNotSayThatThereIsNoSession) {
  const auto text = ask({"status"}).output;
  for (const char* role : {"rig ", "scheduler ", "identification "}) EXPECT_THAT(text, HasSubstr(role));
  EXPECT_THAT(text, HasSubstr("missing"));
  EXPECT_THAT(text, HasSubstr("session: not known without a scheduler"));
  EXPECT_THAT(text, Not(HasSubstr("no session")));
}

TEST_F(StatusOfAnArchiveAlone, SaysTheSameToPrograms) {
  const auto json = nlohmann::json::parse(ask({"status", "--json"}).output);
  EXPECT_EQ(json.at("missing"), (nlohmann::json{"rig", "scheduler", "identification"}));
  EXPECT_EQ(json.at("is_session_known"), false);
  EXPECT_EQ(json.at("session"), nullptr);
}

TEST_F(StatusOfAnArchiveAlone, DoesNotLetACommandSayThatThereIsNoSession) {
  (void)ask({"status"});
  const auto pause = ask({"pause"});
  EXPECT_NE(pause.code, 0);
  EXPECT_THAT(pause.errors, Not(HasSubstr("there is no session")));
  EXPECT_THAT(pause.errors, HasSubstr("heard of"));
}

}  // namespace
}  // namespace tonus::testing
