#include "services/protocol/dry_run.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scheduler_lab/lab.hpp"

namespace tonus::protocol {
namespace {

using ::testing::HasSubstr;

RigFacts facts() { return *facts_of(scheduler::testing::description_of_rig()); }

Protocol small() { return *parse_protocol(scheduler::testing::small_protocol(), "p.toml"); }

TEST(RigFacts, TakeTheForceLimitFromTheWorstDirectionOfTheSensor) {
  EXPECT_NEAR(facts().force_limit, 44.5, 1e-9);  // 4.45 N/V times 10 V: full scale of the published sensor
  auto description = scheduler::testing::description_of_rig();
  description.force_calibration_N_per_V({4.45, 0.0, 0.0, -2.0});
  EXPECT_NEAR(facts_of(description)->force_limit, 20.0, 1e-9);
}

TEST(RigFacts, RefuseAHomeOutOfReach) {
  auto description = scheduler::testing::description_of_rig();
  description.home_m({0.60, 0.30});  // 0.671 m from the base, the links reach 0.65 m
  const auto refused = facts_of(description);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().message,
            "rig 'test': distance of home_m from the base: 0.67082 is not allowed; expected 0.05 to 0.65 m");
}

TEST(DryRun, GivesDurationAndExtremesOfAPlan) {
  const auto run = dry_run(small(), facts(), 1);
  ASSERT_TRUE(run.has_value()) << run.error().message;
  double expected = 0.0;
  for (const auto& trial : run->plan.trials) {
    expected += trial.program.wait_s() + trial.program.hold_s() + kCentringTime + kReturningTime;
  }
  EXPECT_DOUBLE_EQ(run->duration, expected);
  // Home (0.30, 0.35): directions 0 and 180 deg, excursions of 10 mm along x.
  EXPECT_NEAR(run->extremes.farthest, std::hypot(0.31, 0.35), 1e-12);
  EXPECT_NEAR(run->extremes.nearest, std::hypot(0.29, 0.35), 1e-12);
  EXPECT_NEAR(run->extremes.force, 10.0, 1e-12);  // 1000 N/m times 10 mm
  EXPECT_EQ(run->extremes.bias, 0.0);
}

TEST(DryRun, PrintsEveryTrial) {
  const auto text = to_text(*dry_run(small(), facts(), 1), small());
  EXPECT_THAT(text, HasSubstr("small (unloaded): 8 trials in 4 sets"));
  EXPECT_THAT(
      text, HasSubstr("workspace: handle 0.455 to 0.468 m from the robot's base, allowed 0.070 to 0.630 m"));
  EXPECT_THAT(text, HasSubstr("\n    8  far               2"));
}

TEST(DryRun, RefusesWhatLeavesTheWorkspace) {
  auto near_limit = facts();
  near_limit.home = {0.625, 0.0};
  const auto run = dry_run(small(), near_limit, 1);
  ASSERT_FALSE(run.has_value());
  EXPECT_EQ(
      run.error().message,
      "p.toml:14: perturbation.amplitude_m: 0.005 is not allowed; expected less: rig 'test' reaches 0.070 to "
      "0.630 m from its base, and excursions of 0.01 m about its home take it from 0.615 to 0.635 m");
}

TEST(DryRun, RefusesForcesOverTheSensorsRange) {
  auto weak = facts();
  weak.force_limit = 9.0;
  EXPECT_EQ(dry_run(small(), weak, 1).error().message,
            "p.toml:14: perturbation.amplitude_m: 0.005 is not allowed; expected less: rig 'test' measures "
            "up to 9 N, and "
            "the force may reach 10 N");
  weak.force_limit = 0.8;
  const auto loaded = *parse_protocol(scheduler::testing::small_loaded_protocol(), "p.toml");
  EXPECT_EQ(dry_run(loaded, weak, 1).error().message,
            "p.toml:16: bias.force_N: 1 is not allowed; expected less: rig 'test' measures up to 0.8 N");
}

TEST(DryRun, HoldsTheProtocolAgainstTheLimitsThatTheRigStopsAt) {
  auto narrow = facts();
  narrow.stops_at = {narrow.home, 0.012, 30.0};
  const auto run = dry_run(small(), narrow, 1);
  ASSERT_TRUE(run.has_value()) << run.error().message;
  EXPECT_THAT(to_text(*run, small()), HasSubstr("up to 0.010 m from its centre; the rig stops at 0.012 m"));

  narrow.stops_at->workspace_radius = 0.009;
  EXPECT_EQ(
      dry_run(small(), narrow, 1).error().message,
      "p.toml:14: perturbation.amplitude_m: 0.005 is not allowed; expected less: rig 'test' stops at 0.009 "
      "m from the centre of its workspace, and excursions of 0.01 m about its home take it to 0.010 m");
  narrow.stops_at = {narrow.home + Eigen::Vector2d(0.0, 0.07), 0.079, 30.0};
  EXPECT_FALSE(dry_run(small(), narrow, 1).has_value()) << "home is not the workspace's centre";

  narrow.stops_at = {narrow.home, 0.08, 9.0};
  EXPECT_THAT(dry_run(small(), narrow, 1).error().message,
              HasSubstr("rig 'test' stops at 9 N, and the force may reach 10 N"));
  narrow.stops_at->force = 1.8;
  const auto loaded = *parse_protocol(scheduler::testing::small_loaded_protocol(), "p.toml");
  EXPECT_EQ(
      dry_run(loaded, narrow, 1).error().message,
      "p.toml:16: bias.force_N: 1 is not allowed; expected less: rig 'test' takes biases up to 0.9 N, half "
      "of the force at which it stops");
}

TEST(DryRun, TakesTheLimitsFromTheDescription) {
  auto description = scheduler::testing::description_of_rig();
  EXPECT_FALSE(facts_of(description)->stops_at) << "not known is no limit of zero";
  v1::RigLimits limits;
  limits.workspace_centre_m({0.1, 0.2});
  limits.workspace_radius_m(0.05);
  limits.force_N(12.0);
  description.limits({limits});
  const auto stops_at = facts_of(description)->stops_at;
  ASSERT_TRUE(stops_at);
  EXPECT_EQ(stops_at->workspace_centre, Eigen::Vector2d(0.1, 0.2));
  EXPECT_EQ(stops_at->workspace_radius, 0.05);
  EXPECT_EQ(stops_at->force, 12.0);
}

TEST(DryRun, RefusesWhatAOneAxisRigHasNot) {
  auto one_axis = facts();
  one_axis.kind = RigKind::kOneAxis;
  auto p = small();
  EXPECT_TRUE(dry_run(p, one_axis, 1).has_value());
  p.perturbation.directions = 8;
  EXPECT_EQ(
      dry_run(p, one_axis, 1).error().message,
      "p.toml:12: perturbation.directions: 8 is not allowed; expected 1 to 2 on the one-axis rig 'test'");
}

TEST(DryRun, RefusesAStudy) {
  const auto study = parse_protocol(
      "schema = 1\nkind = \"study\"\nname = \"s\"\n[[subject]]\nname = \"a\"\nunloaded = \"u.toml\"\n",
      "p.toml");
  EXPECT_EQ(dry_run(*study, facts(), 1).error().message,
            "p.toml:2: kind: \"study\" is not allowed; expected a protocol of one session; a study's parts "
            "are files "
            "of their "
            "own");
}

}  // namespace
}  // namespace tonus::protocol
