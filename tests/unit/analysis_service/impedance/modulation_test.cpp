#include "analysis_service/impedance/modulation.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace tonus::impedance {
namespace {

Eigen::Matrix2d turned(double major, double minor, double angle) {
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(angle).toRotationMatrix();
  return R * Eigen::Vector2d(major, minor).asDiagonal() * R.transpose();
}

TEST(Modulation, ComparesSizeShapeAndOrientation) {
  const auto m = modulation(turned(600.0, 100.0, 0.5), turned(300.0, 100.0, 0.2));
  ASSERT_TRUE(m);
  EXPECT_NEAR(m->size_ratio, 2.0, 1e-12);
  EXPECT_NEAR(m->shape_ratio, 2.0, 1e-12);
  EXPECT_NEAR(m->rotation, 0.3, 1e-12);
  EXPECT_TRUE(m->has_rotation);
}

TEST(Modulation, TurnsTheShortWayAcrossTheYAxis) {
  EXPECT_NEAR(modulation(turned(3.0, 1.0, -1.5), turned(3.0, 1.0, 1.5))->rotation, 0.1415926535897931, 1e-12);
}

TEST(Modulation, HasNoRotationFromACircle) {
  const auto m = modulation(turned(3.0, 1.0, 0.4), 2.0 * Eigen::Matrix2d::Identity());
  ASSERT_TRUE(m);
  EXPECT_FALSE(m->has_rotation);
  EXPECT_EQ(m->rotation, 0.0);
}

TEST(Modulation, IsNoneForAMatrixThatIsNoEllipse) {
  EXPECT_FALSE(modulation(turned(3.0, -1.0, 0.0), turned(3.0, 1.0, 0.0)));
  EXPECT_FALSE(modulation(turned(3.0, 1.0, 0.0), turned(3.0, -1.0, 0.0)));
}

}  // namespace
}  // namespace tonus::impedance
