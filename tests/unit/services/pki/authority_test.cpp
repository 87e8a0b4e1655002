#include "services/pki/authority.hpp"

#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "services/core/process.hpp"
#include "services/core/text_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::pki {
namespace {

using std::chrono::days;

class AuthorityTest : public ::testing::Test {
 protected:
  Authority make() { return std::move(*Authority::create(folder(), "fastdds", days(3650), now_)); }
  std::filesystem::path folder() const { return folder_ / "authority"; }
  std::filesystem::path host(const std::string& name) const { return folder() / "hosts" / name; }
  static std::string text(const std::filesystem::path& file) { return *read_text_file(file); }

  /// What the openssl program says: an independent reader of our files.
  bool openssl(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "openssl");
    const auto end = run_process(arguments, {});
    return end && end->is_success();
  }
  bool accepts(const std::string& name, const std::string& identity) const {
    return openssl({"verify", "-crl_check", "-CAfile", host(name) / "authority.pem", "-CRLfile",
                    host(name) / "revoked.pem", host(name) / identity / "certificate.pem"});
  }

  testing::TemporaryFolder folder_;
  UtcTime now_ = std::chrono::system_clock::now();
};

TEST_F(AuthorityTest, IssuesWhatAnotherProgramAcceptsAndReadsItsSignatures) {
  Authority authority = make();
  const auto given = authority.issue({.host = "lab-server", .roles = {"services", "viewer"}}, now_);
  ASSERT_TRUE(given) << given.error().message;
  EXPECT_EQ(*given, host("lab-server"));
  for (const char* identity : {"scheduler", "identification", "archive", "viewer"}) {
    EXPECT_TRUE(accepts("lab-server", identity)) << identity;
    EXPECT_TRUE(openssl({"smime", "-verify", "-in", *given / identity / "permissions.p7s", "-CAfile",
                         *given / "authority.pem", "-text"}))
        << identity;
  }
  EXPECT_TRUE(openssl(
      {"smime", "-verify", "-in", *given / "governance.p7s", "-CAfile", *given / "authority.pem", "-text"}));
  const auto state = read_certificate(text(*given / "scheduler" / "certificate.pem"));
  ASSERT_TRUE(state);
  EXPECT_EQ(state->common_name, "scheduler@lab-server");
  EXPECT_EQ(std::chrono::round<std::chrono::minutes>(state->end - now_), std::chrono::minutes(days(365)))
      << "whole seconds are kept";
}

TEST_F(AuthorityTest, RevokedCertificatesAreRefusedByEveryHostsList) {
  Authority authority = make();
  ASSERT_TRUE(authority.issue({.host = "desk", .roles = {"operator", "viewer"}}, now_));
  ASSERT_TRUE(authority.issue({.host = "rig-pc", .roles = {"rig"}}, now_));
  EXPECT_EQ(*authority.revoke("desk", "operator", now_), 1U);
  EXPECT_FALSE(accepts("desk", "operator"));
  EXPECT_TRUE(accepts("desk", "viewer"));
  EXPECT_TRUE(accepts("rig-pc", "rig"));
  const auto serials = read_revocations(text(host("rig-pc") / "revoked.pem"));
  ASSERT_TRUE(serials);
  EXPECT_EQ(serials->size(), 1U) << "the other host's list has it, too";
  EXPECT_EQ(*authority.revoke("desk", "", now_), 1U) << "what is left";
  EXPECT_EQ(authority.revoke("desk", "", now_).error().message, "host 'desk' has no certificate to revoke");
}

TEST_F(AuthorityTest, KnowsWhatItIssuedWhenItIsOpenedAgain) {
  {
    Authority authority = make();
    ASSERT_TRUE(
        authority.issue({.host = "rig-pc", .roles = {"rig"}, .rigs = {"left"}, .validity = days(9)}, now_));
    ASSERT_TRUE(authority.renew("rig-pc", days(20), now_));
    ASSERT_TRUE(authority.revoke("rig-pc", "", now_));
  }
  const auto authority = Authority::open(folder());
  ASSERT_TRUE(authority) << authority.error().message;
  ASSERT_EQ(authority->issued().size(), 2U);
  EXPECT_EQ(authority->issued()[0].serial, 2U);
  EXPECT_TRUE(authority->issued()[0].is_replaced);
  EXPECT_FALSE(authority->issued()[1].is_replaced);
  EXPECT_EQ(authority->issued()[1].rigs, std::vector<std::string>{"left"});
  EXPECT_TRUE(authority->issued()[1].is_revoked);
}

TEST_F(AuthorityTest, RenewGivesNewKeysAndNothingToRevokedHosts) {
  Authority authority = make();
  ASSERT_TRUE(authority.issue({.host = "desk", .roles = {"operator"}, .validity = days(1)}, now_));
  ASSERT_TRUE(authority.issue({.host = "old", .roles = {"viewer"}}, now_));
  ASSERT_TRUE(authority.revoke("old", "", now_));
  const std::string before = text(host("desk") / "operator" / "key.pem");
  EXPECT_EQ(*authority.renew("", days(365), now_), 1U);
  EXPECT_NE(text(host("desk") / "operator" / "key.pem"), before);
  EXPECT_GT(read_certificate(text(host("desk") / "operator" / "certificate.pem"))->end, now_ + days(300));
  EXPECT_EQ(authority.renew("old", days(365), now_).error().code, ErrorCode::kNotFound);
}

TEST_F(AuthorityTest, OutlivesNoAuthority) {
  Authority authority = std::move(*Authority::create(folder(), "fastdds", days(30), now_));
  ASSERT_TRUE(authority.issue({.host = "desk", .roles = {"viewer"}, .validity = days(365)}, now_));
  EXPECT_LT(read_certificate(text(host("desk") / "viewer" / "certificate.pem"))->end, now_ + days(31));
}

TEST_F(AuthorityTest, KeysAreReadableByNobodyElse) {
  Authority authority = make();
  ASSERT_TRUE(authority.issue({.host = "desk", .roles = {"operator"}}, now_));
  struct stat info {};
  ASSERT_EQ(stat((folder() / "authority.key").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777U, 0600U);
  ASSERT_EQ(stat((host("desk") / "operator" / "key.pem").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777U, 0640U);
  ASSERT_EQ(stat(host("desk").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777U, 0750U);
}

TEST_F(AuthorityTest, RefusesWhatItCannotDoInOneLine) {
  Authority authority = make();
  EXPECT_EQ(Authority::create(folder(), "fastdds", days(10), now_).error().code, ErrorCode::kAlreadyExists);
  for (const char* name : {"", "../x", "a b", "x</subject_name>", ".hidden", "-x", "a/b"}) {
    const auto given = authority.issue({.host = name, .roles = {"viewer"}}, now_);
    ASSERT_FALSE(given) << name;
    EXPECT_EQ(given.error().code, ErrorCode::kInvalidArgument);
  }
  EXPECT_FALSE(authority.issue({.host = "a", .roles = {"viewer"}, .rigs = {"<x>"}}, now_));
  EXPECT_FALSE(authority.issue({.host = "a", .roles = {"root"}}, now_));
  EXPECT_TRUE(authority.issued().empty());
  EXPECT_EQ(Authority::open(folder_ / "none").error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(read_certificate("no certificate"));
  EXPECT_FALSE(read_revocations(""));
}

}  // namespace
}  // namespace tonus::pki
