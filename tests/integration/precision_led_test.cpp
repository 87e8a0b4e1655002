#include <algorithm>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sstream>

#include "analysis_service/offline/archived_session.hpp"
#include "services/protocol/estimate_look.hpp"
#include "services/protocol/protocol.hpp"
#include "services/store/open_store.hpp"
#include "tests/integration/demo_run.hpp"

namespace tonus::testing {
namespace {

using ::testing::HasSubstr;

constexpr std::chrono::seconds kLimit{60};

/// The shipped protocol of five postures, at most 16 trials at each, with a goal.
std::filesystem::path protocol_file(const TemporaryFolder& folder, const std::string& keys) {
  std::ostringstream text;
  text << std::ifstream(source_file("deploy/protocols/unloaded.toml")).rdbuf();
  const auto file = folder / "led.toml";
  std::ofstream(file) << text.str() << "\n[stop_when]\n" << keys;
  return file;
}

DemoRun led_run(const TemporaryFolder& folder, const std::string& keys) {
  return DemoRun({protocol_file(folder, keys).string(), "--profile",
                  source_file("deploy/profiles/default.toml").string()});
}

TEST(PrecisionLedSession, StopsAtEachPostureWhenItsIntervalsAreNarrowEnough) {
  TemporaryFolder folder;
  DemoRun run = led_run(folder, "stiffness = 0.05\ntrials_least = 6\n");
  ASSERT_EQ(run.finish(), 0) << run.everything_printed();
  const auto results = run.results();
  ASSERT_EQ(results.at("progress").size(), 5U);
  for (const auto& condition : results.at("progress")) {
    EXPECT_LT(condition.at("counted"), 16) << condition;
    EXPECT_LE(condition.at("precision"), 0.05) << condition;
    EXPECT_THAT(condition.at("finished_because").get<std::string>(), HasSubstr("goal 5 %"));
  }
  // The estimates that it stopped by are those of method refined, made because the protocol needs them.
  const auto session = run.archived();
  const auto estimates = store::newest_estimates(session);
  EXPECT_EQ(std::ranges::count_if(estimates, [](const auto& e) { return e.method() == "refined"; }), 5);
}

/// The first `count` trials of a posture that count.
store::Session first_trials(store::Session session, std::uint32_t posture, std::size_t count) {
  std::erase_if(session.trials, [&](const store::SessionTrial& trial) {
    const bool is_of_it = trial.outcome && store::why_not_counted(trial).empty() &&
                          trial.outcome->value.program().posture_index() == posture;
    if (!is_of_it || count == 0) return true;
    --count;
    return false;
  });
  return session;
}

TEST(PrecisionLedSession, StopsOfflineWhereItStoppedLive) {
  TemporaryFolder folder;
  DemoRun run = led_run(folder, "stiffness = 0.05\ntrials_least = 6\n");
  ASSERT_EQ(run.finish(), 0) << run.everything_printed();
  const auto session = run.archived();
  const auto protocol = protocol::parse_protocol(session.plan.protocol_toml(), "protocol");
  ASSERT_TRUE(protocol) << protocol.error().message;
  const protocol::StopWhen& rule = *protocol->stop_when;
  auto store = store::open_store_for_reading((run.folder() / "data" / "archive.sqlite").string());
  ASSERT_TRUE(store) << store.error().message;
  impedance::Options options;
  options.method = impedance::Method::kRefined;
  const auto progress = run.results().at("progress");
  for (std::uint32_t posture = 0; posture < progress.size(); ++posture) {
    SCOPED_TRACE(posture);
    std::vector<protocol::Look> looks;
    protocol::Ruling ruling;
    for (auto trials = static_cast<std::size_t>(rule.trials_least);
         ruling.end == protocol::LookEnd::kGoesOn && trials <= 16; ++trials) {
      const auto found =
          identification::identify_session(**store, first_trials(session, posture, trials), {options});
      ASSERT_TRUE(found) << found.error().message;
      ASSERT_EQ(found->size(), 1U);
      looks.push_back(protocol::look_at(found->front().estimate));
      ruling = protocol::ruling_on(rule, looks);
    }
    EXPECT_EQ(looks.back().trials, progress[posture].at("counted").get<std::size_t>());
    EXPECT_EQ(looks.back().stiffness, progress[posture].at("precision").get<double>());
    EXPECT_EQ(ruling.because, progress[posture].at("finished_because").get<std::string>());
  }
}

TEST(PrecisionLedSession, SaysWhyItsGoalIsOutOfReach) {
  TemporaryFolder folder;
  DemoRun run = led_run(folder, "stiffness = 0.001\ntrials_most = 10\n");
  ASSERT_EQ(run.finish(), 0) << run.everything_printed();
  for (const auto& condition : run.results().at("progress")) {
    EXPECT_EQ(condition.at("counted"), 10);
    EXPECT_THAT(condition.at("finished_because").get<std::string>(),
                HasSubstr("10 trials, the most allowed: half-width of stiffness"));
    EXPECT_THAT(condition.at("finished_because").get<std::string>(), HasSubstr("which takes about"));
  }
}

TEST(PrecisionLedSession, GoesOnWhereItsSchedulerIsKilledAtTheDecision) {
  TemporaryFolder folder;
  DemoRun run = led_run(folder, "stiffness = 0.05\ntrials_least = 6\n");
  ASSERT_TRUE(run.process().wait_for_output("; finished: ", kLimit)) << run.everything_printed();
  const pid_t victim = child_named(run.process().id(), "tonus-scheduler");
  ASSERT_NE(victim, 0);
  ASSERT_EQ(kill(victim, SIGKILL), 0);
  ASSERT_EQ(run.finish(), 0) << run.everything_printed();
  const auto results = run.results();
  ASSERT_EQ(results.at("progress").size(), 5U);
  for (const auto& condition : results.at("progress")) {
    EXPECT_TRUE(condition.at("is_finished")) << condition;
    EXPECT_LT(condition.at("counted"), 16) << condition;
  }
}

}  // namespace
}  // namespace tonus::testing
