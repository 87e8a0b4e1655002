#include "analysis_service/impedance/reconstruction.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace tonus::impedance {
namespace {

constexpr double kPeriod = 0.005;     // s
constexpr Eigen::Index kOnset = 100;  // rows of rest
constexpr double kRate = 2.0 * std::numbers::pi;

/// A hand that swings along both axes at 1 Hz on M = 2, B = 10, K = 100 (SI, the same on both axes); from
/// sample to sample the force is `jitter` above and below the model's.
Trial swinging(double jitter) {
  Trial trial;
  trial.number = 1;
  trial.sample_period = kPeriod;
  trial.onset = kOnset;
  trial.displacement.resize(500, 2);
  trial.force.resize(500, 2);
  for (Eigen::Index i = 0; i < 500; ++i) {
    const double t = kPeriod * static_cast<double>(i);
    const double x = 0.01 * std::sin(kRate * t);
    const double v = 0.01 * kRate * std::cos(kRate * t);
    const double force = -2.0 * kRate * kRate * x + 10.0 * v + 100.0 * x + (i % 2 == 0 ? jitter : -jitter);
    trial.displacement.row(i).setConstant(x);
    trial.force.row(i).setConstant(force);
  }
  return trial;
}

Estimate true_estimate() {
  Estimate estimate;
  estimate.status = Status::kOk;
  estimate.axes = 2;
  estimate.value.M = 2.0 * Eigen::Matrix2d::Identity();
  estimate.value.B = 10.0 * Eigen::Matrix2d::Identity();
  estimate.value.K = 100.0 * Eigen::Matrix2d::Identity();
  estimate.value.X0 = Eigen::Vector2d::Zero();
  estimate.trials_used = {1};
  return estimate;
}

TEST(Reconstruction, IsTheRootMeanSquareOfWhatTheModelDoesNotMakeOfTheMeasuredForce) {
  const Trial trial = swinging(0.1);
  const auto error = reconstruction_error({&trial, 1}, true_estimate(), {});
  ASSERT_TRUE(error);
  EXPECT_NEAR((*error)[0], 0.1, 1e-3);
  EXPECT_NEAR((*error)[1], 0.1, 1e-3);
}

TEST(Reconstruction, WithoutDampingMissesItsForce) {
  // 10 N s/m at a speed of 0.01 m times 2 pi rad/s: 0.628 N, of which 1 / sqrt(2) is the root mean square.
  const Trial trial = swinging(0.0);
  Estimate estimate = true_estimate();
  estimate.model = Model::kNoDamping;
  estimate.value.B.resize(2, 0);
  const auto error = reconstruction_error({&trial, 1}, estimate, {});
  ASSERT_TRUE(error);
  EXPECT_NEAR((*error)[0], 0.1 * kRate / std::sqrt(2.0), 5e-3);
}

TEST(Reconstruction, RefusesAnUndeterminedEstimateAndForeignTrials) {
  Trial trial = swinging(0.0);
  EXPECT_FALSE(reconstruction_error({&trial, 1}, Estimate{}, {}));
  trial.number = 2;
  EXPECT_FALSE(reconstruction_error({&trial, 1}, true_estimate(), {}));
}

}  // namespace
}  // namespace tonus::impedance
