#include "services/simulation/misconduct.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace tonus::simulation {
namespace {

constexpr double kPeriod = 0.001;

MisconductEffect all_kinds() {
  MisconductEffect effect;
  effect.is_on = true;
  effect.pushes_early = {2};
  effect.drifts_off = {3};
  effect.lets_go = {4};
  return effect;
}

/// The act of trial `trial` after `seconds`, with the hand at `speed` (m/s) all the time.
Misconduct::Act act_of(const MisconductEffect& effect, int trial, double seconds, double speed = 0.0) {
  Misconduct misconduct(effect, kPeriod);
  for (int i = 0; i < trial; ++i) misconduct.begin_trial();
  Misconduct::Act act;
  const auto periods = static_cast<int>(std::lround(seconds / kPeriod));
  for (int i = 0; i <= periods; ++i) act = misconduct.begin_period(speed);
  return act;
}

bool is_well_behaved(const Misconduct::Act& act) {
  return act.force.isZero(0.0) && act.offset.isZero(0.0) && act.is_holding;
}

TEST(Misconduct, HappensInTheChosenTrialsOnly) {
  const double late = 4.65;  // s; a quarter of a period of pushing falls on 2.5 + 0.15 + 3 * 0.6 + ...
  EXPECT_TRUE(is_well_behaved(act_of(all_kinds(), 1, late, 0.1)));
  EXPECT_FALSE(act_of(all_kinds(), 2, late).force.isZero(0.1));
  EXPECT_FALSE(act_of(all_kinds(), 3, late).offset.isZero(0.001));
  EXPECT_FALSE(act_of(all_kinds(), 4, late, 0.1).is_holding);
  EXPECT_TRUE(is_well_behaved(act_of(all_kinds(), 5, late, 0.1)));
}

TEST(Misconduct, BeginsAfterItsTimeAndEndsWithItsTrial) {
  EXPECT_TRUE(is_well_behaved(act_of(all_kinds(), 3, 2.4)));
  Misconduct misconduct(all_kinds(), kPeriod);
  for (int i = 0; i < 3; ++i) misconduct.begin_trial();
  for (int i = 0; i < 5000; ++i) (void)misconduct.begin_period(0.0);
  EXPECT_NEAR(misconduct.begin_period(0.0).offset.y(), 0.009, 1e-12);
  misconduct.begin_trial();
  EXPECT_TRUE(is_well_behaved(misconduct.begin_period(0.0)));
}

TEST(Misconduct, PushesToAndFroWithItsForceAndPeriod) {
  // A quarter of 0.6 s after 2.5 s, and three quarters.
  EXPECT_NEAR(act_of(all_kinds(), 2, 2.65).force.x(), 3.0, 1e-6);
  EXPECT_NEAR(act_of(all_kinds(), 2, 2.95).force.x(), -3.0, 1e-6);
}

TEST(Misconduct, OpensTheHandItsLatencyAfterItWasMoved) {
  EXPECT_TRUE(act_of(all_kinds(), 4, 10.0, 0.04).is_holding);  // slower than it notices
  EXPECT_TRUE(act_of(all_kinds(), 4, 2.79, 0.05).is_holding);
  EXPECT_FALSE(act_of(all_kinds(), 4, 2.81, 0.05).is_holding);
}

TEST(Misconduct, IsOffByDefault) {
  MisconductEffect effect = all_kinds();
  effect.is_on = false;
  for (int trial = 1; trial <= 5; ++trial) EXPECT_TRUE(is_well_behaved(act_of(effect, trial, 4.65, 0.1)));
}

}  // namespace
}  // namespace tonus::simulation
