#include "services/simulation/subject.hpp"

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "services/simulation/plant.hpp"

namespace tonus::simulation {
namespace {

constexpr double kPeriod = 0.001;

// The arm at its posture, at rest, or displaced by `by` (m in S).
ArmMotion arm_at(const SubjectProfile& subject, const Eigen::Vector2d& by = Eigen::Vector2d::Zero()) {
  const Eigen::Vector2d hand = subject.posture + by;
  return {subject.links.angles_at(hand), Eigen::Vector2d::Zero(), hand, Eigen::Vector2d::Zero()};
}

TEST(Subject, DoesNothingButHoldThePostureByDefault) {
  const SubjectProfile profile;
  Subject subject(profile, kPeriod, 1);
  for (int i = 0; i < 1000; ++i) {
    const SubjectDrive& drive = subject.begin_period(arm_at(profile, {0.005, 0.0}));
    ASSERT_EQ(drive.equilibrium, profile.links.angles_at(profile.posture));
    ASSERT_EQ(drive.scale, 1.0);
    ASSERT_TRUE(drive.torque.isZero(0.0));
    ASSERT_TRUE(drive.force.isZero(0.0));
    ASSERT_TRUE(drive.is_holding);
  }
}

TEST(Subject, AnswersByReflexAfterItsDelayAndNotBefore) {
  SubjectProfile profile;
  profile.reflex.is_on = true;
  profile.reflex.delay = 0.040;
  Subject subject(profile, kPeriod, 1);
  const ArmMotion stretched = arm_at(profile, {0.004, 0.003});
  for (int i = 0; i < 40; ++i) ASSERT_TRUE(subject.begin_period(stretched).torque.isZero(0.0)) << i;
  const Eigen::Vector2d deviation = stretched.angles - profile.links.angles_at(profile.posture);
  // [[3 + 1, 1], [1, 3 + 1]] N m/rad against the stretch.
  const Eigen::Vector2d expected(-(4.0 * deviation[0] + deviation[1]), -(deviation[0] + 4.0 * deviation[1]));
  EXPECT_LT((subject.begin_period(stretched).torque - expected).norm(), 1e-12);
}

TEST(Subject, StiffensAgainstTheForceThatItHolds) {
  SubjectProfile profile;
  profile.modulation = {true, 0.4, 0.5};
  Subject subject(profile, kPeriod, 1);
  // Held 1 mm ahead of the posture at rest: the muscles' torque is K (t_eq - t), all of it scaled.
  const ArmMotion held = arm_at(profile, {0.0, 0.001});
  for (int i = 0; i < 20'000; ++i) subject.begin_period(held);
  const double scale = subject.drive().scale;
  const Eigen::Vector2d torque =
      scale * (profile.stiffness.matrix() * (profile.links.angles_at(profile.posture) - held.angles));
  const double force = profile.links.jacobian(held.angles).transpose().partialPivLu().solve(torque).norm();
  EXPECT_GT(scale, 1.1);
  EXPECT_NEAR(scale, 1.0 + 0.4 * force, 1e-6);
}

TEST(Subject, DoesNotStiffenWhileTheHandIsMovedQuickly) {
  SubjectProfile profile;
  profile.modulation = {true, 0.4, 0.5};
  Subject subject(profile, kPeriod, 1);
  ArmMotion pushed = arm_at(profile, {0.0, 0.005});
  pushed.hand_velocity = {0.0, 0.05};
  for (int i = 0; i < 2'000; ++i) ASSERT_EQ(subject.begin_period(pushed).scale, 1.0);
}

TEST(Subject, WandersOffTheTargetInAChosenTrial) {
  SubjectProfile profile;
  profile.misconduct.is_on = true;
  profile.misconduct.drifts_off = {1};
  Subject subject(profile, kPeriod, 1);
  subject.begin_trial();
  for (int i = 0; i < 5'000; ++i) subject.begin_period(arm_at(profile));
  const Eigen::Vector2d wanted = profile.posture + Eigen::Vector2d(0.0, profile.misconduct.drift);
  // One step along the Jacobian of the posture: second order in 9 mm.
  EXPECT_LT((subject.drive().equilibrium - profile.links.angles_at(wanted)).norm(), 2e-3);
}

TEST(Subject, TremblesWithItsForceAtItsFrequency) {
  SubjectProfile profile;
  profile.tremor.is_on = true;
  Subject subject(profile, kPeriod, 1);
  constexpr int kCount = 400'000;
  double squares = 0.0;
  std::complex<double> inside(0.0, 0.0);
  double power_near = 0.0;
  double power_far = 0.0;
  std::vector<double> x;
  for (int i = 0; i < kCount; ++i) {
    x.push_back(subject.begin_period(arm_at(profile)).force.x());
    squares += x.back() * x.back();
  }
  // Power of 1 s pieces at the centre and far from it.
  for (int piece = 0; piece < kCount / 1000; ++piece) {
    std::complex<double> near(0.0, 0.0);
    std::complex<double> far(0.0, 0.0);
    for (int i = 0; i < 1000; ++i) {
      const double value = x[static_cast<std::size_t>(piece * 1000 + i)];
      near += value * std::polar(1.0, -2.0 * std::numbers::pi * 9.0 * i * kPeriod);
      far += value * std::polar(1.0, -2.0 * std::numbers::pi * 30.0 * i * kPeriod);
    }
    power_near += std::norm(near);
    power_far += std::norm(far);
  }
  EXPECT_NEAR(std::sqrt(squares / kCount), 0.1, 0.005);
  EXPECT_GT(power_near, 50.0 * power_far);
}

TEST(Subject, DriftsWithItsForceAndItsTimeConstant) {
  SubjectProfile profile;
  profile.drift.is_on = true;
  profile.drift.time_constant = 0.2;
  Subject subject(profile, kPeriod, 1);
  constexpr int kCount = 1'000'000;
  constexpr int kLag = 200;  // One time constant: correlation 1/e.
  std::vector<double> x;
  for (int i = 0; i < kCount; ++i) x.push_back(subject.begin_period(arm_at(profile)).force.y());
  double squares = 0.0;
  double lagged = 0.0;
  for (int i = 0; i + kLag < kCount; ++i) {
    squares += x[static_cast<std::size_t>(i)] * x[static_cast<std::size_t>(i)];
    lagged += x[static_cast<std::size_t>(i)] * x[static_cast<std::size_t>(i + kLag)];
  }
  EXPECT_NEAR(std::sqrt(squares / (kCount - kLag)), 0.2, 0.01);
  EXPECT_NEAR(lagged / squares, std::exp(-1.0), 0.05);
}

TEST(Subject, PushesBackAfterItsLatencyAgainstTheDisplacement) {
  SubjectProfile profile;
  profile.reaction.is_on = true;
  Subject subject(profile, kPeriod, 1);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(subject.begin_period(arm_at(profile)).force.isZero(0.0));
  const ArmMotion pushed = arm_at(profile, {0.006, 0.0});
  for (int i = 0; i < 250; ++i) ASSERT_TRUE(subject.begin_period(pushed).force.isZero(1e-9)) << i;
  Eigen::Vector2d force = Eigen::Vector2d::Zero();
  for (int i = 0; i < 160; ++i) force = subject.begin_period(pushed).force;
  EXPECT_NEAR(force.x(), -3.0, 1e-6);
  EXPECT_NEAR(force.y(), 0.0, 1e-6);
  for (int i = 0; i < 310; ++i) force = subject.begin_period(arm_at(profile)).force;
  EXPECT_TRUE(force.isZero(0.0));
}

TEST(Subject, LeavesPerturbationsUnansweredAsOftenAsItsProbabilitySays) {
  SubjectProfile profile;
  profile.reaction.is_on = true;
  profile.reaction.probability = 0.25;
  Subject subject(profile, kPeriod, 1);
  int answers = 0;
  for (int trial = 0; trial < 400; ++trial) {
    for (int i = 0; i < 400; ++i) subject.begin_period(arm_at(profile));
    bool has_answered = false;
    for (int i = 0; i < 500; ++i) {
      has_answered = has_answered || subject.begin_period(arm_at(profile, {0.0, 0.006})).force.norm() > 0.1;
    }
    answers += has_answered ? 1 : 0;
  }
  EXPECT_NEAR(answers, 100, 5 * 8.7);  // Five standard deviations of a binomial.
}

TEST(Subject, TiresByTheExponentialLaw) {
  SubjectProfile profile;
  profile.fatigue = {true, 0.4, 2.0};
  Subject subject(profile, kPeriod, 1);
  double scale = 1.0;
  for (int i = 0; i <= 2000; ++i) scale = subject.begin_period(arm_at(profile)).scale;
  EXPECT_NEAR(scale, 1.0 - 0.4 * (1.0 - std::exp(-1.0)), 1e-9);
}

TEST(Subject, LetsGoAndHoldsAgain) {
  PlantProfile profile;
  profile.subject.letting_go = {true, 0.1, 0.2};
  Plant plant(profile, kPeriod);
  ShoulderPose shoulder;  // 10 mm off the spring centre, so that the hold bears force.
  shoulder.origin = profile.manipulandum.home - profile.subject.posture + Eigen::Vector2d(0.01, 0.0);
  plant.seat(shoulder, profile.subject.posture);
  const auto force_after = [&](int cycles) {
    for (int i = 0; i < cycles; ++i) plant.step(Eigen::Vector2d::Zero());
    return (plant.flexure_force()).norm();
  };
  EXPECT_GT(force_after(50), 0.2);
  const double open = force_after(100);  // The handle coasts: only its own inertia is left.
  EXPECT_LT(open, 0.05);
  EXPECT_GT(force_after(160), 0.2);
}

TEST(Subject, RecentresSlowlyAgainstASteadyForceButNotInAPerturbation) {
  SubjectProfile profile;
  profile.recentring.is_on = true;
  Subject subject(profile, kPeriod, 1);
  const Eigen::Vector2d start = profile.links.angles_at(profile.posture);
  ArmMotion quick = arm_at(profile, {0.005, 0.0});
  quick.hand_velocity = {0.05, 0.0};
  subject.begin_period(quick);
  for (int i = 0; i < 1500; ++i) subject.begin_period(arm_at(profile, {0.005, 0.0}));
  EXPECT_EQ(subject.drive().equilibrium, start);
  for (int i = 0; i < 1500; ++i) subject.begin_period(arm_at(profile, {0.005, 0.0}));
  const Eigen::Vector2d shift = profile.links.endpoint(subject.drive().equilibrium) - profile.posture;
  EXPECT_NEAR(shift.x(), -0.005,
              0.0001);  // 5 mm for 1 s at a time constant of 1 s, away from the displacement.
  EXPECT_NEAR(shift.y(), 0.0, 0.0002);
}

}  // namespace
}  // namespace tonus::simulation
