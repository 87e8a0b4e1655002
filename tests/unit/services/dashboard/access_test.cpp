#include "services/dashboard/gateway/access.hpp"

#include <fstream>
#include <gmock/gmock.h>

#include "tests/support/temporary_folder.hpp"

namespace tonus::dashboard {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::string kViewToken = "view-token-0123456789";
const std::string kOperateToken = "operate-token-0123456789";

Access with_tokens() { return Access({{kViewToken}, {kOperateToken}}, {}); }

int status_of(const std::variant<Role, Refusal>& admitted) {
  const auto* refusal = std::get_if<Refusal>(&admitted);
  return refusal == nullptr ? 200 : refusal->http_status;
}

TEST(Access, KnowsItsTokensAndNothingThatIsNotOfATokensForm) {
  const Access access = with_tokens();
  EXPECT_TRUE(access.knows(kViewToken));
  EXPECT_TRUE(access.knows(kOperateToken));
  for (const std::string& token : {std::string(), kViewToken + "\r\nX: y", kViewToken + "; x",
                                   kViewToken + '\0', kViewToken.substr(1), std::string(1 << 20, 'x')})
    EXPECT_FALSE(access.knows(token));
  EXPECT_FALSE(Access({}, {}).knows("")) << "where no token is needed, none is known";
}

TEST(Access, WithoutTokensWhoeverIsOnThisMachineIsAnOperator) {
  const Access access({}, {});
  for (const char* host : {"localhost:8765", "127.0.0.1:8765", "[::1]:8765", "127.1.2.3"}) {
    const auto admitted = access.admit({.host = host});
    ASSERT_EQ(status_of(admitted), 200) << host;
    EXPECT_EQ(std::get<Role>(admitted), Role::kOperate);
  }
}

TEST(Access, WithoutTokensANameThatAPageMadeUpIsRefused) {
  const Access access({}, {});
  for (const char* host :
       {"", "evil.example", "evil.example:8765", "127.0.0.1.evil.example", "localhost.evil"})
    EXPECT_EQ(status_of(access.admit({.host = host})), 403) << host;
}

TEST(Access, PagesOfAForeignOriginAreRefused) {
  const Access access({}, {});
  const std::string host = "localhost:8765";
  EXPECT_EQ(status_of(access.admit({.host = host, .origin = "http://localhost:8765"})), 200);
  EXPECT_EQ(status_of(access.admit({.host = host, .origin = "https://localhost:8765"})), 403);
  EXPECT_EQ(status_of(access.admit({.host = host, .origin = "http://localhost:9999"})), 403);
  EXPECT_EQ(status_of(access.admit({.host = host, .origin = "https://evil.example"})), 403);
  EXPECT_EQ(status_of(access.admit({.host = host, .origin = "null"})), 403);
}

TEST(Access, AnOriginThatIsAllowedMayConnect) {
  const Access access({}, {"https://tool.example"});
  EXPECT_EQ(status_of(access.admit({.host = "localhost", .origin = "https://tool.example"})), 200);
  EXPECT_EQ(status_of(access.admit({.host = "localhost", .origin = "https://tool.example.evil"})), 403);
}

TEST(Access, TokenDecidesTheRole) {
  const Access access = with_tokens();
  const auto role = [&](const std::string& token) {
    return std::get<Role>(access.admit({.host = "lab:1", .authorization = "Bearer " + token}));
  };
  EXPECT_EQ(role(kViewToken), Role::kView);
  EXPECT_EQ(role(kOperateToken), Role::kOperate);
  EXPECT_EQ(std::get<Role>(access.admit({.host = "lab", .query_token = kViewToken})), Role::kView);
}

TEST(Access, WrongOrMissingTokensAreRefusedAndNotRepeatedInTheReason) {
  const Access access = with_tokens();
  EXPECT_EQ(status_of(access.admit({.host = "lab"})), 401);
  const auto wrong = access.admit({.host = "lab", .query_token = kViewToken + "x"});
  ASSERT_EQ(status_of(wrong), 401);
  EXPECT_THAT(std::get<Refusal>(wrong).reason, Not(HasSubstr(kViewToken)));
  EXPECT_EQ(status_of(access.admit({.host = "lab", .authorization = "Basic " + kOperateToken})), 401);
  EXPECT_EQ(status_of(access.admit({.host = "localhost"})), 401);
}

TEST(Access, QueryValuesAreDecoded) {
  EXPECT_EQ(query_value("/?a=1&token=x%2By&b=2", "token"), "x+y");
  EXPECT_EQ(query_value("/", "token"), "");
  EXPECT_EQ(query_value("/?tokens=1", "token"), "");
  EXPECT_EQ(query_value("/?token=%4", "token"), "%4");
}

TEST(Access, CookiesAreFoundByName) {
  EXPECT_EQ(cookie_value("a=1; tonus-report=xyz; b=2", "tonus-report"), "xyz");
  EXPECT_EQ(cookie_value("tonus-report=x=y", "tonus-report"), "x=y");
  EXPECT_EQ(cookie_value("xtonus-report=1; ;", "tonus-report"), "");
  EXPECT_EQ(cookie_value("", "tonus-report"), "");
}

class TokenFile : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& text, std::filesystem::perms mode) {
    const auto path = folder_ / "tokens.toml";
    std::ofstream(path) << text;
    std::filesystem::permissions(path, mode);
    return path;
  }
  static constexpr auto kOwnerOnly = std::filesystem::perms::owner_read | std::filesystem::perms::owner_write;
  testing::TemporaryFolder folder_;
};

TEST_F(TokenFile, IsRead) {
  const auto tokens =
      load_tokens(write("view = ['" + kViewToken + "']\noperate = ['" + kOperateToken + "']", kOwnerOnly));
  ASSERT_TRUE(tokens) << tokens.error().message;
  EXPECT_EQ(tokens->view, std::vector{kViewToken});
  EXPECT_EQ(tokens->operate, std::vector{kOperateToken});
}

TEST_F(TokenFile, ThatOthersCanReadIsRefused) {
  const auto tokens =
      load_tokens(write("view = ['" + kViewToken + "']", kOwnerOnly | std::filesystem::perms::group_read));
  ASSERT_FALSE(tokens);
  EXPECT_THAT(tokens.error().message, HasSubstr("640"));
}

TEST_F(TokenFile, WithAShortTokenIsRefusedWithoutRepeatingIt) {
  const auto tokens = load_tokens(write("view = ['short-secret']", kOwnerOnly));
  ASSERT_FALSE(tokens);
  EXPECT_THAT(tokens.error().message, HasSubstr("token 1 of view"));
  EXPECT_THAT(tokens.error().message, Not(HasSubstr("short-secret")));
}

TEST_F(TokenFile, WithATokenThatAHeaderCannotCarryIsRefused) {
  EXPECT_FALSE(load_tokens(write("view = ['0123456789; 0123456789']", kOwnerOnly)));
}

TEST_F(TokenFile, WithoutTokensOrWithUnknownKeysOrNoTomlIsRefused) {
  EXPECT_FALSE(load_tokens(write("", kOwnerOnly)));
  EXPECT_FALSE(load_tokens(write("admin = ['" + kViewToken + "']", kOwnerOnly)));
  EXPECT_FALSE(load_tokens(write("view = " + kViewToken, kOwnerOnly)));
  EXPECT_FALSE(load_tokens(write("view = '" + kViewToken + "'", kOwnerOnly)));
  EXPECT_FALSE(load_tokens(folder_ / "none.toml"));
}

}  // namespace
}  // namespace tonus::dashboard
