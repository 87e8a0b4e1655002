#include "services/protocol/bias_axes.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

namespace tonus::protocol {
namespace {

/// K with eigenvalues `major` and `minor`, the major axis at `degrees`, and an antisymmetric part.
Eigen::Matrix2d stiffness(double major, double minor, double degrees, double curl = 0.0) {
  const double a = degrees * std::numbers::pi / 180.0;
  const double c = std::cos(a), s = std::sin(a);
  Eigen::Matrix2d k;
  k << major * c * c + minor * s * s, (major - minor) * c * s + curl, (major - minor) * c * s - curl,
      major * s * s + minor * c * c;
  return k;
}

double degrees_of(const Eigen::Vector2d& v) { return std::atan2(v.y(), v.x()) * 180.0 / std::numbers::pi; }

TEST(BiasAxes, AreTheEigenvectorsOfTheSymmetricPart) {
  for (const double angle : {-80.0, -30.0, 0.0, 12.5, 45.0, 89.0}) {
    const auto finding = axes_of_stiffness(stiffness(300.0, 100.0, angle, 40.0));
    ASSERT_EQ(finding.kind, AxesFinding::Kind::kSound) << finding.reason;
    EXPECT_NEAR(degrees_of(finding.axes.major), angle, 1e-9);
    const double minor = angle > 0.0 ? angle - 90.0 : angle + 90.0;  // the sense with an angle in (-90, 90]
    EXPECT_NEAR(degrees_of(finding.axes.minor), minor, 1e-9);
    EXPECT_NEAR(finding.axes.major.norm(), 1.0, 1e-12);
  }
}

TEST(BiasAxes, PointAlongBothSensesOfBothAxes) {
  const BiasAxes axes = axes_of_stiffness(stiffness(300.0, 100.0, 30.0)).axes;
  const double c = std::cos(std::numbers::pi / 6.0), s = 0.5;  // closed form at 30 deg
  EXPECT_TRUE(bias_force(BiasAxis::kMajorPlus, 0.8, axes).isApprox(Eigen::Vector2d(0.8 * c, 0.8 * s), 1e-12));
  EXPECT_TRUE(
      bias_force(BiasAxis::kMajorMinus, 0.8, axes).isApprox(Eigen::Vector2d(-0.8 * c, -0.8 * s), 1e-12));
  EXPECT_TRUE(
      bias_force(BiasAxis::kMinorPlus, 0.8, axes).isApprox(Eigen::Vector2d(0.8 * s, -0.8 * c), 1e-12));
  EXPECT_TRUE(
      bias_force(BiasAxis::kMinorMinus, 0.8, axes).isApprox(Eigen::Vector2d(-0.8 * s, 0.8 * c), 1e-12));
  EXPECT_EQ(bias_force(BiasAxis::kNone, 0.8, axes), Eigen::Vector2d(0.0, 0.0));
}

TEST(BiasAxes, AreDoubtfulForACircle) {
  const auto finding = axes_of_stiffness(stiffness(200.0, 199.0, 30.0));
  EXPECT_EQ(finding.kind, AxesFinding::Kind::kDoubtful);
  EXPECT_EQ(finding.reason, "its stiffness ellipse is a circle, the eigenvalues are 199.0 and 200.0 N/m");
}

TEST(BiasAxes, AreNoneWithoutAnEllipse) {
  EXPECT_EQ(axes_of_stiffness(stiffness(200.0, -5.0, 30.0)).reason,
            "its stiffness is not positive definite, the eigenvalues are -5.0 and 200.0 N/m");
  Eigen::Matrix2d k = stiffness(200.0, 100.0, 30.0);
  k(0, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(axes_of_stiffness(k).kind, AxesFinding::Kind::kNone);
}

v1::Estimate estimate_of_set_one() {
  v1::Estimate e;
  e.session_id(id_of("s"));
  e.posture_index(1);
  e.set_number(1);
  e.method("state_variable");
  e.model("linear");
  e.status(v1::ESTIMATE_OK);
  e.stiffness_N_per_m().value({300.0, 0.0, 0.0, 100.0});
  for (const std::uint32_t attempt : {3u, 4u, 6u}) {
    v1::TrialRange range;
    range.attempt(attempt);
    e.trials().push_back(range);
  }
  return e;
}

TEST(BiasAxes, ComeFromTheLinearUnloadedEstimateOfSetOne) {
  const auto good = estimate_of_set_one();
  const auto is_it = [](const v1::Estimate& e) { return is_of_set_one(e, id_of("s"), 1, "state_variable"); };
  EXPECT_TRUE(is_it(good));
  auto all_sets = good;
  all_sets.set_number(0);
  EXPECT_TRUE(is_it(all_sets));
  auto other = good;
  other.set_number(6);
  EXPECT_FALSE(is_it(other));
  other = good;
  other.posture_index(2);
  EXPECT_FALSE(is_it(other));
  other = good;
  other.method("lowpass");
  EXPECT_FALSE(is_it(other));
  other = good;
  other.model("no_damping");
  EXPECT_FALSE(is_it(other));
  other = good;
  other.bias_N({0.5, 0.5});
  EXPECT_FALSE(is_it(other));
  other = good;
  other.session_id(id_of("t"));
  EXPECT_FALSE(is_it(other));
}

TEST(BiasAxes, KnowWhichTrialsAnEstimateIsMadeWithout) {
  EXPECT_EQ(trials_left_out(estimate_of_set_one(), {3, 4, 6}), 0u);
  EXPECT_EQ(trials_left_out(estimate_of_set_one(), {3, 4, 5, 6, 7}), 2u);
}

TEST(BiasAxes, HeedTheEstimatesStatus) {
  auto e = estimate_of_set_one();
  EXPECT_EQ(axes_of_estimate(e).kind, AxesFinding::Kind::kSound);
  e.reasons({"ill-conditioned"});
  e.status(v1::ESTIMATE_SUSPECT);
  EXPECT_EQ(axes_of_estimate(e).kind, AxesFinding::Kind::kDoubtful);
  EXPECT_EQ(axes_of_estimate(e).reason, "it is suspect: ill-conditioned");
  e.status(v1::ESTIMATE_UNDETERMINED);
  EXPECT_EQ(axes_of_estimate(e).kind, AxesFinding::Kind::kNone);
  EXPECT_EQ(axes_of_estimate(e).reason, "it is undetermined: ill-conditioned");
}

}  // namespace
}  // namespace tonus::protocol
