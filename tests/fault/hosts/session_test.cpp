// A session over three hosts that know each other by an interface and a list of addresses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/pki/authority.hpp"
#include "tests/fault/rig/live_system.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/three_hosts/lab_session.hpp"
#include "tests/support/three_hosts/three_hosts.hpp"

namespace tonus::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::chrono::seconds kLimit{150};

class Hosts : public ::testing::Test {
 protected:
  void SetUp() override {
    auto hosts = ThreeHosts::create();
    if (!hosts) GTEST_SKIP() << hosts.error().message;
    hosts_ = std::move(*hosts);
  }
  /// All samples are stored, and each of so many trials counts once.
  static void expect_whole(const LabSession& session, std::size_t trials) {
    EXPECT_EQ(missing_samples(session.store_file()), "");
    const auto archived = session.archived();
    std::size_t valid = 0;
    for (const auto& trial : archived.trials)
      valid += trial.verdict && trial.verdict->value.is_valid() ? 1 : 0;
    EXPECT_EQ(valid, trials);
  }

  std::unique_ptr<ThreeHosts> hosts_;
};

struct Lab {
  const char* name;
  LabOptions options;
};
std::string lab_name(const ::testing::TestParamInfo<Lab>& info) { return info.param.name; }

class HostsOfEachKind : public Hosts, public ::testing::WithParamInterface<Lab> {};
INSTANTIATE_TEST_SUITE_P(Labs, HostsOfEachKind,
                         ::testing::Values(Lab{"fastdds", {}},
                                           Lab{"cyclonedds",
                                               {.dds = {"cyclonedds", "cyclonedds", "cyclonedds"}}},
                                           Lab{"mixed", {.dds = {"cyclonedds", "fastdds", "cyclonedds"}}},
                                           Lab{"discovery_server", {.has_discovery_server = true}}),
                         lab_name);

TEST_P(HostsOfEachKind, RunASessionTogetherOfWhichNothingIsLost) {
  LabSession session(*hosts_, GetParam().options);
  session.start(1);
  ASSERT_EQ(session.finish(kLimit), 0) << session.everything_printed();
  expect_whole(session, 1);
}

struct Loss {
  const char* dds;
  int percent;
};
std::string loss_name(const ::testing::TestParamInfo<Loss>& info) {
  return std::string(info.param.dds) + "_" + std::to_string(info.param.percent) + "_percent";
}

class HostsOnABadNetwork : public Hosts, public ::testing::WithParamInterface<Loss> {};
INSTANTIATE_TEST_SUITE_P(Losses, HostsOnABadNetwork,
                         ::testing::Values(Loss{"fastdds", 5}, Loss{"fastdds", 20}, Loss{"cyclonedds", 5},
                                           Loss{"cyclonedds", 20}),
                         loss_name);

TEST_P(HostsOnABadNetwork, EndTheSessionAndLoseNothing) {
  const std::string dds = GetParam().dds;
  LabSession session(*hosts_, {.dds = {dds, dds, dds}});
  if (auto lossy = hosts_->lose_percent(GetParam().percent); !lossy)
    GTEST_SKIP() << "needs nft (package nftables): " << lossy.error().message;
  session.start(1);
  ASSERT_EQ(session.finish(kLimit), 0) << session.everything_printed();
  const auto lost = hosts_->lost_packets();
  ASSERT_TRUE(lost) << lost.error().message;
  EXPECT_GT(*lost, 0U);
  ASSERT_TRUE(hosts_->lose_percent(0));
  expect_whole(session, 1);
}

class HostsCutOff : public Hosts, public ::testing::WithParamInterface<const char*> {};
INSTANTIATE_TEST_SUITE_P(Vendors, HostsCutOff, ::testing::Values("fastdds", "cyclonedds"),
                         [](const auto& vendor) { return std::string(vendor.param); });

/// The hold of the trial outlasts the scheduler's silence that a rig bears.
constexpr int kLongHold_s = 8;

TEST_P(HostsCutOff, InATrialTheRigHoldsItselfAndTheSessionEndsAfterTheCableIsBackAndAnOperatorResumes) {
  const std::string dds = GetParam();
  LabSession session(*hosts_, {.dds = {dds, dds, dds}, .resumes_unattended = false});
  session.start(1, kLongHold_s);
  ASSERT_TRUE(session.ask_until(Host::kDesk, "status", "trial 1", kLimit)) << session.everything_printed();
  ASSERT_TRUE(hosts_->cut(Host::kRig));
  ASSERT_TRUE(session.rig_prints("the rig is held: fault: command_timeout", kLimit))
      << session.everything_printed();
  ASSERT_TRUE(session.ask_until(Host::kDesk, "status", "rig is not there", kLimit))
      << session.everything_printed();
  EXPECT_NE(session.ask(Host::kDesk, "clear-fault").code, 0) << "nobody clears a rig that is cut off";
  ASSERT_TRUE(hosts_->connect(Host::kRig));
  ASSERT_TRUE(session.ask_until(Host::kDesk, "clear-fault", "It is free", kLimit))
      << session.everything_printed();
  // The operator resumes as often as the session asks for it: a resume that comes before the scheduler has
  // heard how the rig fared while it was cut off is followed by another request for one.
  const auto deadline = std::chrono::steady_clock::now() + kLimit;
  int ended = Process::kStillRunning;
  while ((ended = session.finish(std::chrono::seconds(0))) == Process::kStillRunning) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline) << session.everything_printed();
    if (session.ask(Host::kDesk, "status").text.find("waiting for: operator: resume") != std::string::npos)
      (void)session.ask(Host::kDesk, "resume");
  }
  ASSERT_EQ(ended, 0) << session.everything_printed();
  expect_whole(session, 1);
}

class HostsSecured : public Hosts, public ::testing::WithParamInterface<const char*> {};
INSTANTIATE_TEST_SUITE_P(Vendors, HostsSecured, ::testing::Values("fastdds", "cyclonedds"),
                         [](const auto& vendor) { return std::string(vendor.param); });

TEST_P(HostsSecured, RunASessionInWhichAViewerSeesAndStopsAndCommandsNothing) {
  const std::string dds = GetParam();
  const TemporaryFolder folder;
  const auto now = std::chrono::system_clock::now();
  auto authority = pki::Authority::create(folder / "pki", dds, std::chrono::days(2), now);
  ASSERT_TRUE(authority) << authority.error().message;
  ASSERT_TRUE(authority->issue({.host = "rig-pc", .roles = {"rig", "viewer"}}, now));
  ASSERT_TRUE(authority->issue({.host = "server", .roles = {"services"}}, now));
  ASSERT_TRUE(authority->issue({.host = "desk", .roles = {"operator"}}, now));
  LabSession session(*hosts_, {.dds = {dds, dds, dds}, .security = folder / "pki" / "hosts"});
  session.start(1);
  ASSERT_EQ(session.finish(kLimit), 0) << session.everything_printed();
  expect_whole(session, 1);
  const auto seen = session.ask(Host::kRig, "status");
  EXPECT_THAT(seen.text, HasSubstr("1 of 1 trials"));
  const auto steered = session.ask(Host::kRig, "abort");
  EXPECT_EQ(steered.code, 1);
  EXPECT_THAT(steered.text, HasSubstr("this host has a viewer's certificate only: it may read and stop"));
  EXPECT_EQ(session.ask(Host::kRig, "stop").code, 0);
  EXPECT_EQ(session.ask(Host::kServer, "status").code, 1) << "services are no operators";
}

TEST_F(Hosts, ASecondServiceOfOneRigIsRefusedByNameAndHostAndTheFirstGoesOn) {
  LabSession session(*hosts_, {});
  session.start(4);
  ASSERT_TRUE(session.ask_until(Host::kDesk, "status", "1 of 4 trials", kLimit))
      << session.everything_printed();
  for (const char* program :
       {"tonus-rig-agent", "tonus-scheduler", "tonus-archive", "tonus-identification"}) {
    const auto second = session.start_beside(Host::kDesk, program);
    EXPECT_EQ(second->wait(kLimit), 1) << program << " " << second->output();
    EXPECT_THAT(second->output(), HasSubstr("'rig' is on the bus: process "));
    EXPECT_THAT(second->output(),
                HasSubstr(std::string(program) == "tonus-rig-agent" ? " on rig-pc" : " on server"));
  }
  ASSERT_EQ(session.finish(kLimit), 0) << session.everything_printed();
  expect_whole(session, 4);
}

TEST_F(Hosts, TwoRigsShareANetworkAndADomainAndHearNothingOfEachOther) {
  LabSession session(*hosts_, {});
  const auto other = session.start_beside(Host::kDesk, "tonus-rig-agent", {"--rig", "other"});
  session.start(1);
  ASSERT_EQ(session.finish(kLimit), 0) << session.everything_printed();
  const auto of_other = session.ask(Host::kDesk, "status", {"--rig", "other"});
  EXPECT_THAT(of_other.text, HasSubstr("rig             other"));
  EXPECT_THAT(of_other.text, ::testing::ContainsRegex("archive +missing"));
  const auto of_first = session.ask(Host::kDesk, "status");
  EXPECT_THAT(of_first.text, HasSubstr("archive         rig"));
  EXPECT_THAT(of_first.text, Not(HasSubstr("other")));
  expect_whole(session, 1);  // one stream of samples, the first rig's
}

}  // namespace
}  // namespace tonus::testing
