#include "services/runtime/network.hpp"

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/core/text_file.hpp"
#include "services/pki/authority.hpp"
#include "services/runtime/security.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::runtime {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Network, IsThisMachineAloneUnlessAnInterfaceIsNamed) {
  const auto network = network_profile({});
  ASSERT_TRUE(network);
  EXPECT_EQ(network->interface_address, "127.0.0.1");
  EXPECT_THAT(network->peers, ElementsAre("127.0.0.1"));
}

TEST(Network, TakesAnInterfaceByNameAndPeersByNameAndAddressEachOnce) {
  CommonOptions options;
  options.interface = "lo";
  options.peers = {"127.0.0.1", "192.0.2.7", "localhost"};
  const auto network = network_profile(options);
  ASSERT_TRUE(network) << network.error().message;
  EXPECT_EQ(network->interface_address, "127.0.0.1");
  EXPECT_THAT(network->peers, ElementsAre("127.0.0.1", "192.0.2.7"));
}

TEST(Network, TakesDiscoveryServersWithAndWithoutPort) {
  CommonOptions options;
  options.interface = "127.0.0.1";
  options.discovery_servers = {"192.0.2.7", "192.0.2.8:4000"};
  const auto network = network_profile(options);
  ASSERT_TRUE(network) << network.error().message;
  ASSERT_EQ(network->discovery_servers.size(), 2U);
  EXPECT_EQ(network->discovery_servers[0].port, 11811);
  EXPECT_EQ(network->discovery_servers[1].port, 4000);
}

TEST(Network, RefusesInOneLineThatNamesTheOption) {
  const auto refusal = [](const CommonOptions& options) {
    const auto network = network_profile(options);
    return network ? std::string("accepted") : network.error().message;
  };
  CommonOptions options;
  options.peers = {"192.0.2.7"};
  EXPECT_THAT(refusal(options), HasSubstr("--interface is missing"));
  options.interface = "nothing0";
  EXPECT_THAT(refusal(options), HasSubstr("--interface: interface 'nothing0'"));
  options.interface = "lo";
  options.peers = {"no host.invalid"};
  EXPECT_THAT(refusal(options), HasSubstr("--peers: 'no host.invalid'"));
  options.peers.clear();
  options.security = "somewhere";
  options.discovery_servers = {"127.0.0.1"};
  EXPECT_THAT(refusal(options), HasSubstr("--discovery-servers: not allowed in a secured domain"));
  options.security.clear();
  for (const char* server : {"127.0.0.1:", "127.0.0.1:0", "127.0.0.1:70000", "127.0.0.1:1x"}) {
    options.discovery_servers = {server};
    EXPECT_THAT(refusal(options), HasSubstr("--discovery-servers: '" + std::string(server)));
  }
}

class SecurityTest : public ::testing::Test {
 protected:
  SecurityTest() {
    options_.security = (folder_ / "pki").string();
    for (const char* identity : {"scheduler", "viewer"}) {
      std::filesystem::create_directories(folder_ / "pki" / identity);
      for (const char* file : {"certificate.pem", "key.pem", "permissions.p7s"})
        put(std::string(identity) + "/" + file);
    }
    for (const char* file : {"authority.pem", "revoked.pem", "governance.p7s"}) put(file);
    put("dds", "fastdds\n");
  }
  void put(const std::string& file, const std::string& text = "x") {
    EXPECT_TRUE(write_text_file(folder_ / "pki" / file, text));
  }
  std::string refusal(const std::string& program) {
    const auto files = security_files(options_, program);
    return files ? std::string("accepted") : files.error().message;
  }

  testing::TemporaryFolder folder_;
  CommonOptions options_;
};

TEST_F(SecurityTest, IsOffUnlessAFolderIsNamed) {
  const auto files = security_files({}, "tonus-scheduler");
  ASSERT_TRUE(files);
  EXPECT_FALSE(files->has_value());
}

TEST_F(SecurityTest, GivesAProgramItsOwnIdentityAlsoForItsSecondParticipant) {
  for (const char* program : {"tonus-scheduler", "tonus-scheduler lease"}) {
    const auto files = security_files(options_, program);
    ASSERT_TRUE(files) << files.error().message;
    EXPECT_EQ((*files)->key, folder_ / "pki" / "scheduler" / "key.pem");
  }
}

TEST_F(SecurityTest, GivesTheCommandLineAViewersIdentityWhereThereIsNoOperators) {
  const auto files = security_files(options_, "tonus");
  ASSERT_TRUE(files) << files.error().message;
  EXPECT_EQ((*files)->key, folder_ / "pki" / "viewer" / "key.pem");
  EXPECT_FALSE(may_command(options_));
  EXPECT_TRUE(may_command({}));
}

TEST_F(SecurityTest, RefusesACertificateThatTheOthersWouldNotTakeBeforeItJoins) {
  using std::chrono::days;
  const auto now = std::chrono::system_clock::now();
  auto authority = pki::Authority::create(folder_ / "authority", "fastdds", days(90), now);
  ASSERT_TRUE(authority) << authority.error().message;
  const auto given = authority->issue({.host = "desk", .roles = {"operator"}, .validity = days(30)}, now);
  ASSERT_TRUE(given) << given.error().message;
  options_.security = given->string();
  const auto refusal_on = [&](std::chrono::system_clock::time_point time) {
    const auto files = security_files(options_, "tonus");
    if (!files) return files.error().message;
    const auto good = check_certificate(**files, time);
    return good ? std::string("accepted") : good.error().message;
  };
  EXPECT_EQ(refusal_on(now), "accepted");
  EXPECT_EQ(refusal_on(now + days(29)), "accepted");
  EXPECT_THAT(refusal_on(now + days(31)),
              AllOf(HasSubstr("operator@desk has expired on 20"), HasSubstr("tonus pki renew")));
  EXPECT_THAT(refusal_on(now - days(31)), HasSubstr("set the clock"));
  ASSERT_TRUE(authority->revoke("desk", "", now));
  EXPECT_THAT(refusal_on(now), HasSubstr("operator@desk is revoked"));
  EXPECT_TRUE(write_text_file(*given / "revoked.pem", "x"));
  EXPECT_THAT(refusal_on(now), HasSubstr("revoked.pem: "));
}

TEST_F(SecurityTest, RefusesInOneLineWhatCannotTakePart) {
  EXPECT_THAT(refusal("tonus-rig-agent"), HasSubstr("this host has no identity 'rig'"));
  options_.dds = "cyclonedds";
  EXPECT_THAT(refusal("tonus-scheduler"),
              HasSubstr("--dds: cyclonedds is not allowed in this secured domain; expected fastdds"));
  options_.dds = "fastdds";
  std::filesystem::remove(folder_ / "pki" / "revoked.pem");
  EXPECT_THAT(refusal("tonus-scheduler"), HasSubstr("revoked.pem"));
  options_.security = (folder_ / "nothing").string();
  EXPECT_THAT(refusal("tonus-scheduler"), HasSubstr("tonus pki issue"));
}

}  // namespace
}  // namespace tonus::runtime
