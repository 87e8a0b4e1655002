// Every fact is made up: nothing of the machine that runs the test is looked at.
#include "services/doctor/findings.hpp"

#include <algorithm>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tonus::doctor {
namespace {

using ::testing::HasSubstr;
using namespace std::chrono_literals;

/// A rig's PC in a lab where everything is as it should be.
Facts healthy() {
  Facts facts;
  facts.is_rig_host = true;
  facts.expected_roles = {"rig", "archive"};
  facts.rig = "left";
  facts.domain = 47;
  facts.clock = ClockFacts{true, 0.0004};
  facts.realtime = RealtimeFacts{99, true, true, "6.1.0-rt-amd64", {"performance"}};
  facts.interface = InterfaceFacts{"eth0", "10.0.0.5", true, false, 1000};
  facts.firewall.rules =
      "table inet filter { chain input { type filter hook input priority 0; policy accept; } }";
  facts.peers = {{"server", "10.0.0.6"}};
  facts.services = {{"rig", "left", "rig-pc", "10.0.0.5", true, "idle", "", {}},
                    {"archive", "left", "server", "10.0.0.6", true, "stores", "", {}}};
  facts.described_rig = RigFacts{"library", false, 0.02, {}};
  facts.disk = {"/var/lib/tonus", "", 200ULL << 30U, 2ms, 9ms};
  facts.permissions = {{"/var/lib/tonus", true, false, false}};
  facts.is_secured = true;
  facts.certificates = {{"rig/certificate.pem", "", "rig@rig-pc", 24h * 200, false}};
  return facts;
}

std::vector<Finding> about(const Facts& facts, const std::string& subject) {
  std::vector<Finding> found;
  for (auto& finding : judge(facts))
    if (finding.subject == subject) found.push_back(std::move(finding));
  return found;
}

TEST(Doctor, FindsNothingToDoInAHealthyLabAndSaysSoOfEverySubject) {
  const auto findings = judge(healthy());
  for (const Finding& finding : findings) {
    EXPECT_EQ(finding.verdict, Verdict::kOk) << finding.subject << ": " << finding.text;
    EXPECT_EQ(finding.remedy, "") << finding.subject;
  }
  for (const char* subject : {"clock", "realtime", "kernel", "governor", "interface", "firewall", "peers",
                              "services", "versions", "disk", "permissions", "certificates", "rig"}) {
    EXPECT_FALSE(about(healthy(), subject).empty()) << subject;
  }
}

struct Fault {
  const char* name;
  const char* subject;
  Verdict verdict;
  const char* text;    ///< Part of what is found.
  const char* remedy;  ///< Part of what to do.
  std::function<void(Facts&)> make;
};
std::string fault_name(const ::testing::TestParamInfo<Fault>& info) { return info.param.name; }

class DoctorFinds : public ::testing::TestWithParam<Fault> {};

TEST_P(DoctorFinds, AndSaysWhatToDo) {
  Facts facts = healthy();
  GetParam().make(facts);
  const auto found = about(facts, GetParam().subject);
  const auto fault =
      std::find_if(found.begin(), found.end(), [](const Finding& f) { return f.verdict != Verdict::kOk; });
  ASSERT_NE(fault, found.end());
  EXPECT_EQ(fault->verdict, GetParam().verdict) << fault->text;
  EXPECT_THAT(fault->text, HasSubstr(GetParam().text));
  EXPECT_THAT(fault->remedy, HasSubstr(GetParam().remedy));
}

constexpr auto kProblem = Verdict::kProblem;
constexpr auto kAdvice = Verdict::kAdvice;

INSTANTIATE_TEST_SUITE_P(
    Faults, DoctorFinds,
    ::testing::Values(
        Fault{"clock_not_synchronised", "clock", kProblem, "not synchronised", "chrony", [](Facts& f) { f.clock->is_synchronised = false; }},
        Fault{"clock_not_known", "clock", kAdvice, "not known", "chrony", [](Facts& f) { f.clock.reset(); }},
        Fault{"clock_far_off", "clock", kAdvice, "wrong by up to 400 ms", "chronyc", [](Facts& f) { f.clock->error_bound_s = 0.4; }},
        Fault{"no_priority", "realtime", kProblem, "priority up to 0 of 80", "systemd", [](Facts& f) { f.realtime->most_priority = 0; }},
        Fault{"no_memory_lock", "realtime", kProblem, "memory may not be locked", "memlock", [](Facts& f) { f.realtime->has_unlimited_memory_lock = false; }},
        Fault{"ordinary_kernel", "kernel", kAdvice, "no realtime kernel", "linux-image-rt", [](Facts& f) { f.realtime->has_realtime_kernel = false; }},
        Fault{"powersave", "governor", kAdvice, "'powersave'", "performance", [](Facts& f) { f.realtime->governors = {"performance", "powersave"}; }},
        Fault{"interface_down", "interface", kProblem, "eth0 10.0.0.5 is down", "ip link set eth0 up", [](Facts& f) { f.interface->is_up = false; }},
        Fault{"slow_interface", "interface", kAdvice, "10 Mbit/s", "switch", [](Facts& f) { f.interface->speed_Mbit_per_s = 10; }},
        Fault{"wrong_interface", "interface", kProblem, "--interface: none", "tonus.toml", [](Facts& f) { f.network_problem = "--interface: none"; }},
        Fault{"firewall_closed", "firewall", kProblem, "UDP 19160-19239", "udp dport 19160-19239 accept", [](Facts& f) { f.firewall.rules = "chain input { type filter hook input priority 0; policy drop; tcp dport 22 accept }"; }},
        Fault{"firewall_open_for_another_domain", "firewall", kProblem, "no rule accepts", "nft add rule", [](Facts& f) { f.firewall.rules = "chain input { type filter hook input priority 0; policy drop;\nudp dport 7410-7489 accept }"; }},
        Fault{"firewall_unreadable", "firewall", kAdvice, "cannot be read", "as root", [](Facts& f) { f.firewall.rules.reset(); }},
        Fault{"silent_peer", "peers", kAdvice, "peer server (10.0.0.6)", "firewall", [](Facts& f) { f.services.pop_back(); }},
        Fault{"unknown_peer", "peers", kProblem, "peer server is a name", "/etc/hosts", [](Facts& f) { f.peers[0].address = ""; }},
        Fault{"absent_service", "services", kProblem, "archive of rig 'left' is not heard", "systemctl", [](Facts& f) { f.services.pop_back(); }},
        Fault{"service_not_ready", "services", kAdvice, "archive on server is not ready: disk full", "do what it says", [](Facts& f) { f.services[1].is_ready = false; f.services[1].state = "disk full"; }},
        Fault{"other_version", "versions", kProblem, "archive on server has version 9", "one version", [](Facts& f) { f.services[1].difference = "archive on server has version 9"; }},
        Fault{"unreadable_version", "versions", kProblem, "3 reports", "one version", [](Facts& f) { f.unreadable_reports = 3; }},
        Fault{"bus_refused", "bus", kProblem, "--dds", "option", [](Facts& f) { f.bus_problem = "--dds: x"; }},
        Fault{"full_disk", "disk", kProblem, "1.1 GB free", "make room", [](Facts& f) { f.disk.free_bytes = 1ULL << 30U; }},
        Fault{"slow_disk", "disk", kProblem, "sync 300.0 ms", "network share", [](Facts& f) { f.disk.median_sync = 300ms; f.disk.worst_sync = 400ms; }},
        Fault{"uneven_disk", "disk", kAdvice, "worst 80.0 ms", "receipts", [](Facts& f) { f.disk.worst_sync = 80ms; }},
        Fault{"no_data_folder", "disk", kProblem, "Permission denied", "--data", [](Facts& f) { f.disk.problem = "Permission denied"; }},
        Fault{"foreign_latch", "permissions", kProblem, "hold cannot be used", "chown", [](Facts& f) { f.permissions.push_back({"rig/left/hold", false, false, false}); }},
        Fault{"open_data", "permissions", kAdvice, "read by everybody", "chmod o=", [](Facts& f) { f.permissions[0].is_open_to_all = true; }},
        Fault{"open_key", "permissions", kProblem, "private key", "issue it anew", [](Facts& f) { f.permissions.push_back({"key.pem", true, true, true}); }},
        Fault{"certificate_ends", "certificates", kAdvice, "rig@rig-pc ends in 29 days", "renew", [](Facts& f) { f.certificates[0].left = 24h * 29; }},
        Fault{"certificate_expired", "certificates", kProblem, "expired 2 days ago", "renew", [](Facts& f) { f.certificates[0].left = -48h; }},
        Fault{"certificate_revoked", "certificates", kProblem, "rig@rig-pc is revoked", "issue", [](Facts& f) { f.certificates[0].is_revoked = true; }},
        Fault{"certificate_unreadable", "certificates", kProblem, "cannot be read", "copy", [](Facts& f) { f.certificates[0].problem = "cannot be read"; }},
        Fault{"no_identity", "certificates", kProblem, "no identity", "issue", [](Facts& f) { f.certificates.clear(); }},
        Fault{"no_security", "certificates", kAdvice, "everybody on the network", "pki init", [](Facts& f) { f.is_secured = false; }},
        Fault{"no_watchdog", "rig", kProblem, "no watchdog", "disable()", [](Facts& f) { f.described_rig->watchdog_s = 0.0; }},
        Fault{"limit_off", "rig", kAdvice, "speed", "rig's file", [](Facts& f) { f.described_rig->limits_off = {"speed"}; }},
        Fault{"no_rig", "rig", kAdvice, "'left' has not described itself", "start", [](Facts& f) { f.described_rig.reset(); }}),
    fault_name);

TEST(Doctor, AcceptsAFirewallThatLetsThePortsOfTheDomainThrough) {
  Facts facts = healthy();
  facts.firewall.rules =
      "chain input { type filter hook input priority 0; policy drop;\nip saddr 10.0.0.6 udp dport "
      "19100-19300 accept }";
  EXPECT_EQ(about(facts, "firewall")[0].verdict, Verdict::kOk);
}

TEST(Doctor, AsksNoRealtimeOfAHostWithoutARig) {
  Facts facts = healthy();
  facts.is_rig_host = false;
  facts.realtime = RealtimeFacts{};
  for (const char* subject : {"realtime", "kernel"})
    EXPECT_EQ(about(facts, subject)[0].verdict, Verdict::kOk);
}

TEST(Doctor, AsksNeitherFirewallNorCertificatesOfOneMachineAlone) {
  Facts facts = healthy();
  facts.interface = InterfaceFacts{"lo", "127.0.0.1", true, true, {}};
  facts.peers.clear();
  facts.firewall.rules.reset();
  facts.is_secured = false;
  for (const Finding& finding : judge(facts)) EXPECT_EQ(finding.verdict, Verdict::kOk) << finding.subject;
}

TEST(Doctor, KnowsThePortsOfADomain) {
  // RTPS 2.3, 9.6.1.1: 7400 + 250 d + 10 + 2 p, p = 0 to 39, and one more for data.
  EXPECT_EQ(ports_of(0).first, 7410);
  EXPECT_EQ(ports_of(0).last, 7489);
  EXPECT_EQ(ports_of(47).first, 19160);
}

}  // namespace
}  // namespace tonus::doctor
