#include "rig_agent/control/validation.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace tonus::control {
namespace {

TrialProgram sound_program() {
  TrialProgram program;
  program.number = 1;
  program.posture = {0.0, 0.38};
  program.shoulder = shoulder_for({0.30, 0.35}, program.posture, 0.4);
  return program;
}

TEST(Validation, AcceptsTheDefaults) {
  EXPECT_TRUE(validate(SafetyLimits{}));
  EXPECT_TRUE(validate(ServoGains{}));
  EXPECT_TRUE(validate(LoopConfig{}));
  EXPECT_TRUE(validate(sound_program(), SafetyLimits{}));
}

TEST(Validation, NamesFieldValueAndWhatIsAllowed) {
  SafetyLimits limits;
  limits.force = 1000.0;
  EXPECT_EQ(validate(limits).error().message, "limits: force_N: 1000 is not allowed; expected 0.5 to 100");
  LoopConfig config;
  config.rate = 8000.0;
  EXPECT_EQ(validate(config).error().message, "loop: rate_Hz: 8000 is not allowed; expected 50 to 4000");
  TrialProgram program = sound_program();
  program.wait = -1.0;
  EXPECT_EQ(validate(program, SafetyLimits{}).error().message,
            "trial: wait_s: -1 is not allowed; expected 0 to 60");
}

TEST(Validation, RefusesValuesThatAreNotNumbers) {
  TrialProgram program = sound_program();
  program.direction = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(validate(program, SafetyLimits{}));
  program = sound_program();
  program.shoulder.angle = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(validate(program, SafetyLimits{}));
  ServoGains gains;
  gains.hold_frequency = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(validate(gains));
}

TEST(Validation, RefusesAPostureThatTheWorkspaceDoesNotHold) {
  TrialProgram program = sound_program();
  program.shoulder.origin.x() += 0.075;  // 75 mm off; the radius is 80 mm, the step needs 10 mm.
  const auto result = validate(program, SafetyLimits{});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().message,
            "trial: distance of the posture from the workspace's centre (m): 0.075 is not allowed; expected "
            "at most 0.07 "
            "(radius 0.08 less twice the amplitude)");
}

TEST(Validation, RefusesABiasAboveHalfOfTheForceLimit) {
  TrialProgram program = sound_program();
  program.bias = {16.0, 0.0};
  EXPECT_EQ(validate(program, SafetyLimits{}).error().message,
            "trial: bias (N): 16 is not allowed; expected at most 15 (half of the force limit)");
}

TEST(Validation, AsksARecordingsProgramForItsNumberAlone) {
  TrialProgram program;
  EXPECT_EQ(validate(program, SafetyLimits{}, false).error().message,
            "trial: number: 0 is not allowed; expected 1 or more");
  program.number = 1;
  EXPECT_TRUE(validate(program, SafetyLimits{}, false));
}

TEST(ShoulderFor, PutsThePostureUnderTheHandle) {
  const Eigen::Vector2d home(0.30, 0.35);
  const Eigen::Vector2d p_SE(0.295, 0.38);
  const ShoulderPose pose = shoulder_for(home, p_SE, 0.7);
  // p_R = origin + Rot(0.7) p_SE, written out.
  const double x = pose.origin.x() + std::cos(0.7) * 0.295 - std::sin(0.7) * 0.38;
  const double y = pose.origin.y() + std::sin(0.7) * 0.295 + std::cos(0.7) * 0.38;
  EXPECT_NEAR(x, 0.30, 1e-12);
  EXPECT_NEAR(y, 0.35, 1e-12);
}

}  // namespace
}  // namespace tonus::control
