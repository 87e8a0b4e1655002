#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sstream>

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
