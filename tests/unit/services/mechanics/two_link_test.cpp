#include "services/mechanics/two_link.hpp"

#include <gtest/gtest.h>
#include <numbers>

namespace tonus {
namespace {

constexpr TwoLink kArm{0.30, 0.35};

TEST(TwoLink, StretchedAlongXReachesTheSumOfItsLengths) {
  EXPECT_TRUE(kArm.endpoint({0.0, 0.0}).isApprox(Eigen::Vector2d(0.65, 0.0)));
}

TEST(TwoLink, WithARightElbowReachesByPythagoras) {
  // First link along x, second along y: closed form.
  EXPECT_TRUE(kArm.endpoint({0.0, std::numbers::pi / 2}).isApprox(Eigen::Vector2d(0.30, 0.35)));
}

TEST(TwoLink, AnglesInvertTheEndpointWithTheElbowOfARightArm) {
  for (double x = -0.4; x <= 0.4; x += 0.1) {
    for (double y = 0.2; y <= 0.45; y += 0.05) {
      const Eigen::Vector2d point(x, y);
      ASSERT_TRUE(kArm.reaches(point));
      const Eigen::Vector2d angles = kArm.angles_at(point);
      EXPECT_GT(angles[1], 0.0);
      EXPECT_LT(angles[1], std::numbers::pi);
      EXPECT_LT((kArm.endpoint(angles) - point).norm(), 1e-12);
    }
  }
}

TEST(TwoLink, JacobianIsTheDerivativeOfTheEndpoint) {
  const Eigen::Vector2d angles(0.4, 1.2);
  constexpr double kStep = 1e-6;
  Eigen::Matrix2d numeric;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(i);
    numeric.col(i) = (kArm.endpoint(angles + step) - kArm.endpoint(angles - step)) / (2 * kStep);
  }
  EXPECT_LT((kArm.jacobian(angles) - numeric).norm(), 1e-9);
}

TEST(TwoLink, JacobianRateIsTheDerivativeOfTheJacobianAlongTheMotion) {
  const Eigen::Vector2d angles(0.4, 1.2);
  const Eigen::Vector2d rates(0.7, -1.1);
  constexpr double kStep = 1e-6;
  const Eigen::Matrix2d numeric =
      (kArm.jacobian(angles + kStep * rates) - kArm.jacobian(angles - kStep * rates)) / (2 * kStep);
  EXPECT_LT((kArm.jacobian_rate(angles, rates) - numeric).norm(), 1e-9);
}

TEST(TwoLink, DoesNotReachBeyondItsLengthsOrInsideTheirDifference) {
  EXPECT_FALSE(kArm.reaches({0.65, 0.0}));
  EXPECT_FALSE(kArm.reaches({0.0, 0.049}));
  EXPECT_TRUE(kArm.reaches({0.0, 0.06}));
}

}  // namespace
}  // namespace tonus
