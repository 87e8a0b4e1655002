#include "analysis_service/impedance/ellipse.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

namespace tonus::impedance {
namespace {

constexpr double kPi = std::numbers::pi;

Eigen::Matrix2d turned(double major, double minor, double angle) {
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(angle).toRotationMatrix();
  return R * Eigen::Vector2d(major, minor).asDiagonal() * R.transpose();
}

TEST(Ellipse, HasTheEigenvaluesAndDirectionOfATurnedDiagonalMatrix) {
  for (int degrees = -89; degrees <= 90; degrees += 1) {
    const double angle = degrees * kPi / 180.0;
    const auto ellipse = ellipse_of(turned(300.0, 40.0, angle));
    ASSERT_TRUE(ellipse);
    EXPECT_NEAR(ellipse->major, 300.0, 1e-10);
    EXPECT_NEAR(ellipse->minor, 40.0, 1e-10);
    EXPECT_NEAR(ellipse->size, kPi * 12000.0, 1e-7);
    EXPECT_NEAR(ellipse->shape, 7.5, 1e-11);
    EXPECT_NEAR(rotation_between(angle, ellipse->orientation), 0.0, 1e-12) << degrees;
    EXPECT_GT(ellipse->orientation, -0.5 * kPi - 1e-12);
    EXPECT_LE(ellipse->orientation, 0.5 * kPi);
  }
}

TEST(Ellipse, IsWellDefinedOnTheAxes) {
  EXPECT_EQ(ellipse_of(turned(2.0, 1.0, 0.0))->orientation, 0.0);
  const Eigen::Matrix2d along_y = Eigen::Vector2d(1.0, 2.0).asDiagonal();
  EXPECT_DOUBLE_EQ(ellipse_of(along_y)->orientation, 0.5 * kPi);
}

TEST(Ellipse, AgreesWithThePrintedFormulas) {
  // (7a)-(7d) evaluated as printed for s1 = 180, s2 = -100, s3 = 340.
  const double s1 = 180.0;
  const double s2 = -100.0;
  const double s3 = 340.0;
  const double root = std::sqrt((s1 + s3) * (s1 + s3) + 4.0 * (s2 * s2 - s1 * s3));
  const double l2 = 0.5 * (s1 + s3 + root);
  const double l1 = 0.5 * (s1 + s3 - root);
  Eigen::Matrix2d Z;
  Z << s1, s2 + 7.0, s2 - 7.0, s3;  // The antisymmetric part must not matter.
  const auto ellipse = ellipse_of(Z);
  ASSERT_TRUE(ellipse);
  EXPECT_NEAR(ellipse->major, l2, 1e-10);
  EXPECT_NEAR(ellipse->minor, l1, 1e-10);
  EXPECT_NEAR(ellipse->orientation, std::atan((l2 - s1) / s2), 1e-12);
  EXPECT_NEAR(ellipse->orientation, std::atan(s2 / (l2 - s3)), 1e-12);
}

TEST(Ellipse, FlagsACircle) {
  const auto circle = ellipse_of(3.0 * Eigen::Matrix2d::Identity());
  ASSERT_TRUE(circle);
  EXPECT_TRUE(circle->is_circle);
  EXPECT_EQ(circle->orientation, 0.0);
  EXPECT_FALSE(ellipse_of(turned(3.001, 3.0, 0.3))->is_circle);
}

TEST(Ellipse, IsRefusedWithAReasonWhereTheMatrixIsNotPositiveDefinite) {
  EXPECT_FALSE(ellipse_of(turned(5.0, -1.0, 0.4)));
  EXPECT_EQ(not_an_ellipse(turned(5.0, -1.0, 0.4)), "not positive definite");
  EXPECT_EQ(not_an_ellipse(turned(-5.0, -1.0, 0.4)), "not positive definite");
  EXPECT_FALSE(curl_of(turned(5.0, 0.0, 0.0)));
  Eigen::Matrix2d broken = Eigen::Matrix2d::Identity();
  broken(1, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(not_an_ellipse(broken), "not finite");
  EXPECT_EQ(not_an_ellipse(Eigen::Matrix2d::Identity()), "ok");
}

TEST(Ellipse, SplitsAMatrixIntoItsParts) {
  Eigen::Matrix2d Z;
  Z << 1.0, 5.0, 1.0, 2.0;
  EXPECT_EQ(symmetric_part(Z)(0, 1), 3.0);
  EXPECT_EQ(antisymmetric_part(Z)(0, 1), 2.0);
  EXPECT_EQ(symmetric_part(Z) + antisymmetric_part(Z), Z);
}

TEST(Curl, IsTheSkewPartOverTheEigenvalues) {
  Eigen::Matrix2d Z = turned(400.0, 100.0, 0.6);
  Z(0, 1) += 10.0;
  Z(1, 0) -= 10.0;
  const auto curl = curl_of(Z);
  ASSERT_TRUE(curl);
  EXPECT_NEAR(curl->p_min, 10.0 / 400.0, 1e-12);
  EXPECT_NEAR(curl->p_max, 10.0 / 100.0, 1e-12);
  EXPECT_NEAR(curl->p_mean, 10.0 / 200.0, 1e-12);
}

TEST(Ellipse, TurnsTheShortWayBetweenOrientations) {
  EXPECT_NEAR(rotation_between(80.0 * kPi / 180.0, -80.0 * kPi / 180.0), 20.0 * kPi / 180.0, 1e-12);
  EXPECT_NEAR(rotation_between(0.2, 0.1), -0.1, 1e-12);
}

}  // namespace
}  // namespace tonus::impedance
