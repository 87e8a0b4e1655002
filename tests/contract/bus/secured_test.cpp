// DDS Security by role, each vendor with itself: who may join, write and read.
#include <algorithm>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <net/ethernet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <netpacket/packet.h>
#include <string_view>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "idl/topics.hpp"
#include "services/core/file_descriptor.hpp"
#include "services/core/text_file.hpp"
#include "services/pki/authority.hpp"
#include "services/pki/documents.hpp"
#include "tests/contract/bus/contract_fixture.hpp"
#include "tests/support/bus/private_network.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::bus::test {
namespace {

using std::chrono::days;
using tonus::test::eventually;
using tonus::testing::TemporaryFolder;

constexpr char kMarker[] = "the hand of subject sub-01 is pushed";

/// One topic of the contract, as bytes.
TopicSpec topic_of(std::string_view name) {
  for (const TopicSpec& spec : topics::kAll)
    if (spec.name == name) return spec;
  return {};
}

Payload marked_payload(std::uint8_t key) {
  Payload made{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
  made.insert(made.end(), 16, std::byte{key});
  for (const char c : std::string_view(kMarker)) made.push_back(static_cast<std::byte>(c));
  return made;
}

/// An authority that gave every role to one host, for rig "left".
class Lab {
 public:
  explicit Lab(Vendor vendor, std::chrono::system_clock::time_point now = std::chrono::system_clock::now())
      : vendor_(vendor),
        authority_(
            *pki::Authority::create(folder_ / "authority", std::string(vendor_name(vendor)), days(30), now)) {
    host_ = *authority_.issue({.host = "host",
                               .roles = {"rig", "services", "operator", "viewer", "subject"},
                               .rigs = {"left"},
                               .validity = days(10)},
                              now);
  }
  [[nodiscard]] pki::Authority& authority() { return authority_; }
  [[nodiscard]] SecurityFiles files(const std::string& identity) const {
    const auto own = host_ / identity;
    return {host_ / "authority.pem", host_ / "revoked.pem",    own / "certificate.pem",
            own / "key.pem",         host_ / "governance.p7s", own / "permissions.p7s"};
  }
  /// Files of an identity whose holder leaves the authority's governance aside: its own program checks no
  /// permission, neither its own nor another's, so that only the others can keep it out.
  [[nodiscard]] SecurityFiles unchecked_files(const std::string& identity) const {
    std::string lax = pki::governance_document();
    for (const std::string_view rule : {"enable_join_access_control>true", "enable_read_access_control>true",
                                        "enable_write_access_control>true"}) {
      const auto at = lax.find(rule);
      lax.replace(at + rule.find("true"), 4, "false");
    }
    const auto keys = pki::KeyPair{*read_text_file(authority_.folder() / "authority.pem"),
                                   *read_text_file(authority_.folder() / "authority.key")};
    SecurityFiles own = files(identity);
    own.governance = folder_ / (identity + "-governance.p7s");
    std::ofstream(own.governance) << *pki::sign(lax, keys);
    return own;
  }
  [[nodiscard]] BusOptions options(const std::optional<SecurityFiles>& files,
                                   const std::string& rig = "left") const {
    BusOptions options = bus_options(vendor_);
    options.partition = rig;
    options.security = files;
    return options;
  }
  [[nodiscard]] std::unique_ptr<Bus> join(const std::string& identity) const {
    return open_bus(options(files(identity)));
  }

 private:
  Vendor vendor_;
  TemporaryFolder folder_;
  pki::Authority authority_;
  std::filesystem::path host_;
};

class SecuredBus : public ::testing::TestWithParam<Vendor> {
 protected:
  SecuredBus() : lab_(GetParam()) {}

  /// An intruder with these files tries ten times to write to and read from a rig and an operator who talk
  /// to each other; both stay out of its reach. `spied_topic`: of the rig, one that the intruder may not
  /// read.
  void expect_nothing_for(const std::optional<SecurityFiles>& files,
                          std::string_view spied_topic = "rig/state") {
    const auto rig = lab_.join("rig");
    const auto operating = lab_.join("operator");
    auto notifier = std::make_shared<Notifier>();
    auto commands_heard = rig->create_reader(topic_of("rig/command"), notifier);
    auto commands = operating->create_writer(topic_of("rig/command"));
    auto states = rig->create_writer(topic_of(spied_topic));
    ASSERT_TRUE(commands_heard && commands && states);
    const auto intruder = create_bus(lab_.options(files));
    Result<std::unique_ptr<Writer>> false_commands = fail(ErrorCode::kUnavailable, "no bus");
    Result<std::unique_ptr<Reader>> spied_states = fail(ErrorCode::kUnavailable, "no bus");
    if (intruder) {
      false_commands = (*intruder)->create_writer(topic_of("rig/command"));
      spied_states = (*intruder)->create_reader(topic_of(spied_topic), notifier);
    }
    for (std::uint64_t attempt = 0; attempt < 10; ++attempt) {
      // A newcomer who is let in has been found by both: so the intruder could have been.
      const auto newcomer = lab_.join("viewer");
      auto known_states = newcomer->create_reader(topic_of(spied_topic), notifier);
      ASSERT_TRUE(known_states);
      if (false_commands) (void)(*false_commands)->write(payload(9, attempt));
      ASSERT_TRUE(eventually([&] { return (*known_states)->status().matched_writers == 1; },
                             std::chrono::seconds(60)));
      ASSERT_TRUE((*states)->write(payload(1, attempt)));
      ASSERT_TRUE(
          eventually([&] { return (*commands)->status().matched_readers == 1; }, std::chrono::seconds(60)));
      ASSERT_TRUE((*commands)->write(payload(1, attempt)));
      ASSERT_EQ(receive(**known_states, *notifier, 1).size(), 1U);
      const auto heard = receive(**commands_heard, *notifier, 1);
      ASSERT_EQ(heard.size(), 1U);
      EXPECT_EQ(heard[0].key[15], 1) << "an intruder's command arrived";
    }
    std::vector<Sample> spied;
    if (spied_states) (*spied_states)->take(spied);
    EXPECT_TRUE(spied.empty());
    EXPECT_EQ((*commands_heard)->status().matched_writers, 1);
  }

  Lab lab_;
};
INSTANTIATE_TEST_SUITE_P(Carriers, SecuredBus, ::testing::Values(Vendor::kFastDds, Vendor::kCycloneDds),
                         carrier_name);

TEST_P(SecuredBus, CarriesMessagesBetweenThoseWhoMay) {
  const auto rig = lab_.join("rig");
  const auto archive = lab_.join("archive");
  auto notifier = std::make_shared<Notifier>();
  auto reader = archive->create_reader(topic_of("rig/samples"), notifier);
  auto writer = rig->create_writer(topic_of("rig/samples"));
  ASSERT_TRUE(reader && writer);
  ASSERT_TRUE(are_matched(**writer, **reader));
  for (std::uint64_t number = 0; number < 50; ++number) ASSERT_TRUE((*writer)->write(payload(1, number)));
  EXPECT_EQ(receive(**reader, *notifier, 50).size(), 50U);
}

TEST_P(SecuredBus, AParticipantWithoutCertificateGetsNothingAndSendsNothing) {
  expect_nothing_for(std::nullopt);
}

TEST_P(SecuredBus, AParticipantOfAnotherAuthorityGetsNothingAndSendsNothing) {
  const Lab other(GetParam());
  expect_nothing_for(other.files("operator"));
}

TEST_P(SecuredBus, AParticipantWithOurAuthoritysFilesAndAForeignCertificateGetsNothingAndSendsNothing) {
  const Lab other(GetParam());
  SecurityFiles files = lab_.files("operator");
  files.certificate = other.files("operator").certificate;
  files.key = other.files("operator").key;
  expect_nothing_for(files);
}

TEST_P(SecuredBus, AnExpiredParticipantGetsNothingAndSendsNothing) {
  // Its own files say so, too: a program with an honest clock does not even begin.
  ASSERT_TRUE(
      lab_.authority().issue({.host = "late", .roles = {"operator"}, .rigs = {"left"}, .validity = days(1)},
                             std::chrono::system_clock::now() - days(3)));
  const auto own = lab_.authority().folder() / "hosts" / "late" / "operator";
  SecurityFiles files = lab_.files("operator");
  files.certificate = own / "certificate.pem";
  files.key = own / "key.pem";
  files.permissions = own / "permissions.p7s";
  expect_nothing_for(files);
}

TEST_P(SecuredBus, ARevokedParticipantGetsNothingAndSendsNothingAlsoWithTheListFromBefore) {
  ASSERT_TRUE(lab_.authority().issue({.host = "lost", .roles = {"operator"}, .rigs = {"left"}},
                                     std::chrono::system_clock::now()));
  const auto folder = lab_.authority().folder() / "hosts" / "lost";
  const TemporaryFolder kept;
  std::filesystem::copy(folder, kept / "lost", std::filesystem::copy_options::recursive);
  ASSERT_TRUE(lab_.authority().revoke("lost", "", std::chrono::system_clock::now()));
  const auto own = kept / "lost" / "operator";
  expect_nothing_for(SecurityFiles{kept / "lost" / "authority.pem", kept / "lost" / "revoked.pem",
                                   own / "certificate.pem", own / "key.pem", kept / "lost" / "governance.p7s",
                                   own / "permissions.p7s"});
}

TEST_P(SecuredBus, AParticipantOfAnotherRoleGetsNothingAndSendsNothingThoughItsOwnProgramChecksNothing) {
  expect_nothing_for(lab_.unchecked_files("subject"), "rig/timing");
}

TEST_P(SecuredBus, AnIdentityWritesNoTopicOfAnother) {
  struct Denied {
    const char* identity;
    const char* topic;
  };
  for (const auto& [identity, topic] :
       {Denied{"identification", "rig/command"}, Denied{"identification", "trial/command"},
        Denied{"archive", "rig/command"}, Denied{"viewer", "rig/command"},
        Denied{"viewer", "session/command"}, Denied{"subject", "rig/command"},
        Denied{"operator", "rig/state"}, Denied{"scheduler", "archive/receipt"}}) {
    EXPECT_FALSE(lab_.join(identity)->create_writer(topic_of(topic))) << identity << " may write " << topic;
  }
  EXPECT_TRUE(lab_.join("viewer")->create_writer(topic_of("rig/stop")));
  EXPECT_FALSE(lab_.join("subject")->create_reader(topic_of("estimate/condition"), nullptr));
}

TEST_P(SecuredBus, SomebodyElsesPermissionsAreOfNoUse) {
  SecurityFiles files = lab_.files("identification");
  files.permissions = lab_.files("operator").permissions;
  EXPECT_FALSE(create_bus(lab_.options(files)));
}

TEST_P(SecuredBus, AnIdentityOfOneRigCommandsNoOther) {
  const auto other = create_bus(lab_.options(lab_.files("operator"), "right"));
  ASSERT_TRUE(other) << other.error().message;
  EXPECT_FALSE((*other)->create_writer(topic_of("rig/command")));
}

/// Everything that passes the loopback interface of this process's network.
class Capture {
 public:
  Capture() : socket_(socket(AF_PACKET, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, htons(ETH_P_ALL))) {
    sockaddr_ll address{};
    address.sll_family = AF_PACKET;
    address.sll_protocol = htons(ETH_P_ALL);
    address.sll_ifindex = static_cast<int>(if_nametoindex("lo"));
    is_open_ = bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  [[nodiscard]] bool is_open() const { return is_open_; }
  [[nodiscard]] std::string take() const {
    std::string all;
    std::vector<char> packet(1 << 17U);
    for (ssize_t size = 0; (size = recv(socket_.get(), packet.data(), packet.size(), 0)) > 0;)
      all.append(packet.data(), static_cast<std::size_t>(size));
    return all;
  }

 private:
  FileDescriptor socket_;
  bool is_open_ = false;
};

TEST_P(SecuredBus, ShowsNoReadablePayloadOnTheNetwork) {
  if (!tonus::test::is_in_private_network()) GTEST_SKIP() << "needs a network namespace of its own";
  const Capture capture;
  if (!capture.is_open()) GTEST_SKIP() << "needs the right to capture packets";
  for (const bool is_secured : {false, true}) {
    const auto rig = open_bus(lab_.options(is_secured ? std::optional(lab_.files("rig")) : std::nullopt));
    const auto archive =
        open_bus(lab_.options(is_secured ? std::optional(lab_.files("archive")) : std::nullopt));
    auto notifier = std::make_shared<Notifier>();
    auto reader = archive->create_reader(topic_of("rig/samples"), notifier);
    auto writer = rig->create_writer(topic_of("rig/samples"));
    ASSERT_TRUE(reader && writer);
    ASSERT_TRUE(are_matched(**writer, **reader));
    (void)capture.take();  // what discovery said would fill it
    ASSERT_TRUE((*writer)->write(marked_payload(1)));
    ASSERT_EQ(receive(**reader, *notifier, 1).size(), 1U);
    const std::string seen = capture.take();
    EXPECT_EQ(seen.find(kMarker) == std::string::npos, is_secured);
    EXPECT_GT(seen.size(), sizeof kMarker);
  }
}

}  // namespace
}  // namespace tonus::bus::test
