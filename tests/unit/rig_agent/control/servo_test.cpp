#include "rig_agent/control/servo.hpp"

#include <Eigen/LU>
#include <cmath>
#include <gtest/gtest.h>

namespace tonus::control {
namespace {

constexpr double kPeriod = 0.001;
const TwoLink kLinks{0.30, 0.35};

// Rigid manipulandum without friction under the servo's torque, integrated in steps of a tenth of the period.
struct FreeHandle {
  ManipulandumModel model;
  Eigen::Vector2d q = kLinks.angles_at({0.30, 0.35});
  Eigen::Vector2d rates = Eigen::Vector2d::Zero();

  void step(const Eigen::Vector2d& torque) {
    for (int i = 0; i < 10; ++i) {
      const TwoLinkState s(kLinks, q);
      const Eigen::Matrix2d h = model.inertia.mass_matrix(s.cos_q2);
      rates += 0.1 * kPeriod * (h.inverse() * (torque - model.inertia.coriolis(s.sin_q2, rates)));
      q += 0.1 * kPeriod * rates;
    }
  }
  [[nodiscard]] Eigen::Vector2d position() const { return kLinks.endpoint(q); }
};

// x(t) / step of x" + 2 z w x' + w^2 x = w^2.
double step_response(double w, double z, double t) {
  const double wd = w * std::sqrt(1.0 - z * z);
  return 1.0 - std::exp(-z * w * t) * (std::cos(wd * t) + z / std::sqrt(1.0 - z * z) * std::sin(wd * t));
}

TEST(Servo, MakesTheFreeHandleASecondOrderSystemInEveryDirection) {
  for (int k = 0; k < 8; ++k) {
    const ServoGains gains;
    FreeHandle handle;
    Servo servo(kLinks, handle.model, gains, kPeriod);
    const Eigen::Vector2d direction(std::cos(k * 0.785398), std::sin(k * 0.785398));
    Reference reference;
    reference.mode = ServoMode::kRing;
    reference.frequency = 18.0;
    const Eigen::Vector2d home = handle.position();
    reference.position = home + 0.005 * direction;
    double worst = 0.0;
    for (int i = 0; i < 500; ++i) {
      worst =
          std::max(worst, (handle.position() - home -
                           0.005 * step_response(18.0, gains.perturbation_damping, i * kPeriod) * direction)
                              .norm());
      servo.observe(handle.q, Eigen::Vector2d::Zero());
      handle.step(servo.torque(reference));
    }
    // The closed form knows no sampling: half a period's delay at 18 rad/s and 87 mm/s peak is 0.05 mm and
    // grows.
    EXPECT_LT(worst, 0.25e-3) << "direction " << k;
  }
}

TEST(Servo, FollowsAReferenceWithItsDerivatives) {
  FreeHandle handle;
  Servo servo(kLinks, handle.model, ServoGains{}, kPeriod);
  const Eigen::Vector2d home = handle.position();
  double worst = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double t = i * kPeriod;
    Reference reference;
    reference.mode = ServoMode::kLead;
    reference.position = home + 0.01 * Eigen::Vector2d(1.0 - std::cos(3.0 * t), 0.0);
    reference.velocity = 0.03 * Eigen::Vector2d(std::sin(3.0 * t), 0.0);
    reference.acceleration = 0.09 * Eigen::Vector2d(std::cos(3.0 * t), 0.0);
    servo.observe(handle.q, Eigen::Vector2d::Zero());
    handle.step(servo.torque(reference));
    worst = std::max(worst, (handle.position() - reference.position).norm());
  }
  EXPECT_LT(worst, 0.1e-3);
}

TEST(Servo, FloatsWithExactlyTheForceAskedForAtRest) {
  FreeHandle handle;
  Servo servo(kLinks, handle.model, ServoGains{}, kPeriod);
  Reference reference;
  reference.force = {0.6, -0.4};
  servo.observe(handle.q, reference.force);  // The arm bears exactly that force.
  const Eigen::Vector2d torque = servo.torque(reference);
  const Eigen::Vector2d expected = kLinks.jacobian(handle.q).transpose() * reference.force;
  EXPECT_NEAR((torque - expected).norm(), 0.0, 1e-12);
}

TEST(Servo, IntegratesAForceErrorAwayOnlyWhileItControlsForce) {
  FreeHandle handle;
  const ServoGains gains;
  Servo servo(kLinks, handle.model, gains, kPeriod);
  Reference reference;
  reference.force = {0.5, 0.0};
  reference.corrects_force = true;
  const Eigen::Matrix2d to_force = kLinks.jacobian(handle.q).transpose().inverse();
  const auto exerted = [&] { return Eigen::Vector2d(to_force * servo.torque(reference)); };
  servo.observe(handle.q, {0.3, 0.0});  // 0.2 N short.
  for (int i = 0; i < 999; ++i) (void)servo.torque(reference);
  EXPECT_NEAR(exerted().x(), 0.5 + gains.force_trim * 0.2, 1e-3);  // After 1 s.
  reference.corrects_force = false;
  for (int i = 0; i < 1000; ++i) (void)servo.torque(reference);
  EXPECT_NEAR(exerted().x(), 0.5, 1e-3);
}

TEST(Servo, ObservesTheVelocityOfAMovingHandle) {
  FreeHandle handle;
  Servo servo(kLinks, handle.model, ServoGains{}, kPeriod);
  const Reference floating;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector2d q = kLinks.angles_at({0.30 + 0.00003 * i, 0.35});
    servo.observe(q, Eigen::Vector2d::Zero());
    (void)servo.torque(floating);
  }
  // Force-free floating predicts a deceleration of d v; the observer's pole pair w leaves v (1 - 2 d / w) or
  // so.
  EXPECT_NEAR(servo.estimate().velocity.x(), 0.03, 0.03 * 0.35);
  EXPECT_NEAR(servo.estimate().velocity.y(), 0.0, 1e-4);
}

TEST(Servo, DampsInTheSafeStateUntilAtRestAndThenGivesNoTorque) {
  FreeHandle handle;
  handle.rates = {0.4, -0.2};
  Servo servo(kLinks, handle.model, ServoGains{}, kPeriod);
  double largest = 0.0;
  int cycles = 0;
  for (; cycles < 20'000 && !servo.is_released(); ++cycles) {
    servo.observe(handle.q, Eigen::Vector2d::Zero());
    const Eigen::Vector2d torque = servo.safe_torque(3.0, 0.5);
    largest = std::max(largest, torque.cwiseAbs().maxCoeff());
    handle.step(torque);
  }
  EXPECT_TRUE(servo.is_released());
  EXPECT_LE(largest, 0.5);
  EXPECT_GT(largest, 0.1);
  EXPECT_LT(handle.rates.norm(), 0.02);
  EXPECT_EQ(servo.safe_torque(3.0, 0.5), Eigen::Vector2d::Zero());
}

}  // namespace
}  // namespace tonus::control
