#include "services/dashboard/gateway/metrics.hpp"

#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/core/process.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::dashboard {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const Id kRig = id_of("rig/rig");
const Id kSession = id_of("session");

class MetricsTest : public ::testing::Test {
 protected:
  template <typename T>
  void publish(const topics::Topic<T>& topic, const Id& key, const T& value, std::uint64_t time_ns = 1) {
    for (const auto& offered : hub_.topics()) {
      if (offered.channel.topic != topic.spec.name) continue;
      hub_.on_bus_message(
          {offered.channel.id, key, time_ns, std::make_shared<const bus::Payload>(*bus::encode(value))});
    }
  }

  std::string text() const { return bus_metrics(hub_, 7, 3); }

  void publish_rig() {
    v1::RigState state;
    state.rig_id(kRig);
    state.mode(v1::RIG_HELD);
    state.hold_number(4);
    state.next_sequence(5000);
    state.received_through(4000);
    state.dropped_samples(2);
    state.spool_bytes(123456);
    publish(topics::kRigState, kRig, state);
    v1::RigTiming timing;
    timing.rig_id(kRig);
    timing.period_s(0.001);
    timing.cycles(100);
    timing.overruns(3);
    timing.missed_periods(9);
    timing.worst_lateness_ns(2'500'000);
    timing.lateness_count()[0] = 90;
    timing.lateness_count()[1] = 7;
    timing.lateness_count()[17] = 3;
    publish(topics::kRigTiming, kRig, timing);
  }

  SystemClock clock_;
  Hub hub_{offered_topics(), {}, clock_, [](OperatorRequest) {}};
};

/// Every line is in the format, every metric has HELP and TYPE once and before its samples, no series comes
/// twice, and counters end in _total. The rules are those of Prometheus' "Exposition formats", text format.
void expect_well_formed(const std::string& text) {
  static const std::regex kSample(
      R"re(([a-z_]+)(\{[a-z_]+="([^"\\]|\\.)*"(,[a-z_]+="([^"\\]|\\.)*")*\})? (NaN|[+-]Inf|-?[0-9.]+(e[+-]?[0-9]+)?))re");
  std::map<std::string, std::string> kinds;
  std::set<std::string> series;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string mark;
    std::string what;
    std::string name;
    if (line.starts_with('#')) {
      words >> mark >> what >> name;
      if (what != "TYPE") continue;
      EXPECT_FALSE(kinds.contains(name)) << line;
      words >> kinds[name];
      EXPECT_EQ(kinds[name] == "counter", name.ends_with("_total")) << line;
      EXPECT_THAT(text, HasSubstr("# HELP " + name + " ")) << line;
      continue;
    }
    std::smatch parts;
    ASSERT_TRUE(std::regex_match(line, parts, kSample)) << line;
    EXPECT_TRUE(series.insert(line.substr(0, line.rfind(' '))).second) << line;
    name = std::regex_replace(std::string(parts[1]), std::regex("_(bucket|sum|count)$"), "");
    EXPECT_TRUE(kinds.contains(parts[1]) || kinds[name] == "histogram") << line;
  }
}

TEST_F(MetricsTest, TellsWhatTheRigSaysInBaseUnits) {
  publish_rig();
  const std::string all = text();
  const std::string rig = "{rig=\"" + to_hex(kRig) + "\"} ";
  for (const std::string& line :
       {"tonus_rig_samples_total" + rig + "5000", "tonus_rig_held" + rig + "1",
        "tonus_rig_receipted_samples_total" + rig + "4000", "tonus_rig_dropped_samples_total" + rig + "2",
        "tonus_rig_spool_bytes" + rig + "123456", "tonus_rig_missed_periods_total" + rig + "9",
        "tonus_rig_worst_lateness_seconds" + rig + "0.0025"})
    EXPECT_THAT(all, HasSubstr(line + "\n"));
  expect_well_formed(all);
}

TEST_F(MetricsTest, CountsLatenessUpToEachLimit) {
  publish_rig();
  const auto late = [&](const std::string& le) {
    return "tonus_rig_late_cycles_total{rig=\"" + to_hex(kRig) + "\",le=\"" + le + "\"} ";
  };
  EXPECT_THAT(text(), HasSubstr(late("1e-06") + "90\n"));
  EXPECT_THAT(text(), HasSubstr(late("2e-06") + "97\n"));
  EXPECT_THAT(text(), HasSubstr(late("0.065536") + "97\n"));
  EXPECT_THAT(text(), HasSubstr(late("+Inf") + "100\n"));
}

TEST_F(MetricsTest, WhatNobodyHasSaidIsLeftOutAndNotZero) {
  EXPECT_THAT(text(), Not(HasSubstr("tonus_rig_")));
  EXPECT_THAT(text(), Not(HasSubstr("tonus_service_")));
  EXPECT_THAT(text(), Not(HasSubstr("tonus_session_")));
  EXPECT_THAT(text(), HasSubstr("tonus_gateway_arrival_drops_total 7\n"));
  EXPECT_THAT(text(), HasSubstr("tonus_gateway_connections 3\n"));
  expect_well_formed(text());
}

TEST_F(MetricsTest, AServicesNameMayHoldAnything) {
  v1::ServiceHealth health;
  health.name("a\"b\\c\nd\xff");
  health.is_ready(true);
  health.lag_s(0.25);
  health.dropped(11);
  publish(topics::kServiceHealth, id_of("1"), health);
  EXPECT_THAT(text(), HasSubstr("service=\"a\\\"b\\\\c d?\""));
  EXPECT_THAT(text(), HasSubstr("tonus_service_lag_seconds{"));
  expect_well_formed(text());
  health.is_leaving(true);
  publish(topics::kServiceHealth, id_of("1"), health);
  EXPECT_THAT(text(), Not(HasSubstr("tonus_service_"))) << "who has left is no service any more";
}

TEST_F(MetricsTest, CountsTheTimeFromATrialsEndToItsResultsOnce) {
  constexpr std::uint64_t kEnd = 1'700'000'000'000'000'000;
  publish(topics::kTrialOutcome, trial_id(kSession, 3), v1::TrialOutcome(), kEnd);
  for (int i = 0; i < 2; ++i)
    publish(topics::kTrialVerdict, trial_id(kSession, 3), v1::TrialVerdict(), kEnd + 15'000'000);
  v1::Estimate estimate;
  estimate.session_id(kSession);
  estimate.trials().resize(2);
  estimate.trials()[1].attempt(3);
  publish(topics::kEstimateCondition, id_of("e"), estimate, kEnd + 250'000'000);
  EXPECT_THAT(text(), HasSubstr("tonus_verdict_latency_seconds_bucket{le=\"0.01\"} 0\n"));
  EXPECT_THAT(text(), HasSubstr("tonus_verdict_latency_seconds_bucket{le=\"0.02\"} 1\n"));
  EXPECT_THAT(text(), HasSubstr("tonus_verdict_latency_seconds_count 1\n"));
  EXPECT_THAT(text(), HasSubstr("tonus_estimate_latency_seconds_sum 0.25\n"));
  EXPECT_THAT(text(), HasSubstr("tonus_estimate_latency_seconds_bucket{le=\"0.2\"} 0\n"));
  EXPECT_THAT(text(), HasSubstr("tonus_estimate_latency_seconds_bucket{le=\"0.5\"} 1\n"));
  expect_well_formed(text());
}

TEST_F(MetricsTest, TheExampleDashboardShowsWhatThereIs) {
  publish_rig();
  publish(topics::kServiceHealth, id_of("1"), v1::ServiceHealth());
  v1::SessionState session;
  session.phase(v1::SESSION_RUNNING);
  publish(topics::kSessionState, kSession, session);
  // Of files, as the tests below have them.
  const std::string all = text() +
                          " tonus_archive_bytes tonus_archive_disk_free_bytes"
                          " tonus_tls_certificate_expiry_timestamp_seconds";
  std::ifstream file(testing::source_file("deploy/grafana/tonus.json"));
  const std::string dashboard((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const std::regex name("tonus_[a-z_]+");
  std::set<std::string> names;
  for (std::sregex_iterator found(dashboard.begin(), dashboard.end(), name), end; found != end; ++found)
    names.insert(found->str());
  EXPECT_GE(names.size(), 20U);
  for (const std::string& shown : names) EXPECT_THAT(all, HasSubstr(shown));
}

TEST(FileMetrics, TellSizesAndTheCertificatesEnd) {
  const testing::TemporaryFolder folder;
  const std::string store = (folder / "archive.sqlite").string();
  std::ofstream(store) << std::string(1234, 'x');
  const std::string certificate = (folder / "certificate.pem").string();
  const auto made = run_process(
      {"openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes",
       "-days", "30", "-subj", "/CN=x", "-keyout", (folder / "key.pem").string(), "-out", certificate},
      {});
  ASSERT_TRUE(made && made->is_success());
  const std::string all = file_metrics(store, certificate);
  EXPECT_THAT(all, HasSubstr("tonus_archive_bytes 1234\n"));
  EXPECT_THAT(all, HasSubstr("tonus_archive_disk_free_bytes "));
  expect_well_formed(all);
  std::smatch end;
  ASSERT_TRUE(std::regex_search(all, end,
                                std::regex("tonus_tls_certificate_expiry_timestamp_seconds ([0-9.e+]+)\n")));
  const double now = 1e-9 * static_cast<double>(SystemClock().utc_ns());
  EXPECT_NEAR(std::stod(end[1]) - now, 30 * 86400.0, 3600.0);
}

TEST(FileMetrics, LeaveOutWhatCannotBeRead) {
  EXPECT_EQ(file_metrics("/none/archive.sqlite", "/none.pem"), "");
  EXPECT_EQ(file_metrics("postgresql://lab@host/study", ""), "");
}

}  // namespace
}  // namespace tonus::dashboard
