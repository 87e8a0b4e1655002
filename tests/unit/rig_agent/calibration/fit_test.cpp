#include "rig_agent/calibration/fit.hpp"

#include <Eigen/LU>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace tonus::calibration {
namespace {

// Volts of loads in eight directions through a known sensor: v = C^-1 f + offset.
std::vector<KnownForce> readings(const Eigen::Matrix2d& matrix, const Eigen::Vector2d& offset,
                                 double noise_V) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise(0.0, noise_V);
  std::vector<KnownForce> all;
  for (int k = 0; k < 8; ++k) {
    const double angle = 0.785398163397448 * k;
    const Eigen::Vector2d force(10.0 * std::cos(angle), 10.0 * std::sin(angle));
    Eigen::Vector2d volts = matrix.inverse() * force + offset;
    if (noise_V > 0.0) volts += Eigen::Vector2d(noise(random), noise(random));
    all.push_back({force, volts});
  }
  return all;
}

Eigen::Matrix2d sensor() {
  Eigen::Matrix2d m;
  m << 4.6, 0.21, -0.13, 4.3;
  return m;
}

TEST(ForceFit, FindsMatrixAndOffsetOfASensorWithCrosstalk) {
  const auto fit = fit_force(readings(sensor(), {0.12, -0.07}, 0.0));
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_TRUE(fit->matrix.isApprox(sensor(), 1e-12));
  EXPECT_TRUE(fit->offset.isApprox(Eigen::Vector2d(0.12, -0.07), 1e-12));
  EXPECT_LT(fit->residual, 1e-12);
}

TEST(ForceFit, TellsTheNoiseOfTheReadingsAsItsResidual) {
  const auto fit = fit_force(readings(sensor(), {0.0, 0.0}, 0.01));
  ASSERT_TRUE(fit);
  // 10 mV through about 4.45 N/V; 10 degrees of freedom: within a factor of two.
  EXPECT_GT(fit->residual, 0.5 * 0.0445);
  EXPECT_LT(fit->residual, 2.0 * 0.0445);
}

TEST(ForceFit, RefusesLoadsInOneDirectionAndTooFew) {
  std::vector<KnownForce> line;
  for (int k = 0; k < 5; ++k) line.push_back({{1.0 * k, 0.0}, {0.2 * k, 0.001 * k}});
  const auto fit = fit_force(line);
  ASSERT_FALSE(fit);
  EXPECT_NE(fit.error().message.find("use other directions"), std::string::npos) << fit.error().message;
  const auto all = readings(sensor(), {0.0, 0.0}, 0.0);
  const auto few = fit_force(std::span(all).first(3));
  ASSERT_FALSE(few);
  EXPECT_EQ(few.error().message, "readings of known forces: 3 is not allowed; expected 4 or more");
}

TEST(SpringFit, FindsTheStiffnessMatrixAndItsDirections) {
  Eigen::Matrix2d stiffness;
  stiffness << 400.0, 30.0, 20.0, 250.0;
  std::vector<SpringStep> steps;
  for (int k = 0; k < 6; ++k) {
    const Eigen::Vector2d x(0.006 * std::cos(1.0 * k), 0.006 * std::sin(1.0 * k));
    steps.push_back({x, stiffness * x});
  }
  const auto fit = fit_spring(steps);
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_TRUE(fit->stiffness.isApprox(stiffness, 1e-12));
  EXPECT_NEAR(fit->along(0.0), 400.0, 1e-9);
  EXPECT_NEAR(fit->along(1.5707963267948966), 250.0, 1e-9);
  EXPECT_NEAR(fit->mean(), 325.0, 1e-9);
  EXPECT_LT(fit->standard_error.maxCoeff(), 1e-6);
}

}  // namespace
}  // namespace tonus::calibration
