#include "analysis_service/impedance/mean_motion.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace tonus::impedance::test {
namespace {

constexpr double kPeriod = 0.005;    // s
constexpr Eigen::Index kRest = 100;  // rows
constexpr Eigen::Index kRows = 330;
constexpr double kRate = 25.0;  // 1/s

/// x = 1 - (1 + s + s^2 / 2) exp(-s), s = kRate t: from rest without a jump of acceleration.
Eigen::Vector3d closed_form(Eigen::Index row) {
  const double s = kRate * kPeriod * static_cast<double>(row - kRest);
  if (s <= 0.0) return Eigen::Vector3d::Zero();
  const double e = std::exp(-s);
  return {1.0 - (1.0 + s + 0.5 * s * s) * e, kRate * 0.5 * s * s * e, kRate * kRate * (s - 0.5 * s * s) * e};
}

/// Four trials along and against two directions, 5 mm, the second of which also moves the first axis.
std::vector<Trial> trials_with_noise(double noise) {
  const Eigen::Matrix2d response = (Eigen::Matrix2d() << 1.0, 0.3, 0.0, 0.8).finished();
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0.0, noise);
  std::vector<Trial> trials;
  for (const auto& [x, y] : {std::pair{1.0, 0.0}, {0.0, 1.0}, {-1.0, 0.0}, {0.0, -1.0}}) {
    Trial trial;
    trial.number = static_cast<std::uint32_t>(trials.size() + 1);
    trial.sample_period = kPeriod;
    trial.onset = kRest;
    trial.displacement.resize(kRows, 2);
    for (Eigen::Index k = 0; k < kRows; ++k) {
      const Eigen::Vector2d moved = 0.005 * closed_form(k)[0] * response * Eigen::Vector2d(x, y);
      trial.displacement.row(k) << moved.x() + normal(random), moved.y() + normal(random);
    }
    trials.push_back(trial);
  }
  return trials;
}

refined::CommandMotion motion_of(const std::vector<Trial>& trials) {
  std::vector<const Trial*> pointers;
  pointers.reserve(trials.size());
  for (const Trial& trial : trials) pointers.push_back(&trial);
  return mean_motion(pointers, 1.0);
}

/// Of trial 2, by axis 1: place, rate and acceleration in m and s.
Eigen::Vector3d of_second_trial(const refined::CommandMotion& motion, Eigen::Index row) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Eigen::Index b = 0; b < 2; ++b) {
    const refined::AxisMotion& one = motion.of_axis[static_cast<std::size_t>(b)];
    sum += motion.targets(1, b) * Eigen::Vector3d(one.x(row, 1), one.v(row, 1), one.a(row, 1));
  }
  return sum;
}

TEST(MeanMotion, HasTheDerivativesOfTheMotionThatTrialsHaveInCommon) {
  const refined::CommandMotion motion = motion_of(trials_with_noise(1e-7));
  Eigen::Vector3d error = Eigen::Vector3d::Zero();
  Eigen::Vector3d whole = Eigen::Vector3d::Zero();
  for (Eigen::Index row = kRest; row < kRest + 60; ++row) {
    const Eigen::Vector3d expected = 0.8 * 0.005 * closed_form(row);
    error += (of_second_trial(motion, row) - expected).cwiseAbs2();
    whole += expected.cwiseAbs2();
  }
  const Eigen::Vector3d share = error.cwiseQuotient(whole).cwiseSqrt();
  EXPECT_LT(share[0], 0.001);
  EXPECT_LT(share[1], 0.01);
  EXPECT_LT(share[2], 0.05);
}

TEST(MeanMotion, IsNoneWhereTheDisplacementsDoNotSpanTheAxes) {
  auto trials = trials_with_noise(0.0);
  for (Trial& trial : trials) trial.displacement.col(1).setZero();
  EXPECT_EQ(motion_of(trials).rest, 0);
  EXPECT_TRUE(motion_of(trials).of_axis.empty());
}

TEST(MeanMotion, IsAtRestBeforeTheOnset) {
  const refined::CommandMotion motion = motion_of(trials_with_noise(2e-6));
  EXPECT_EQ(motion.rest, kRest);
  for (const refined::AxisMotion& one : motion.of_axis) {
    EXPECT_TRUE(one.x.topRows(kRest + 1).isZero(1e-12));
    EXPECT_TRUE(one.v.topRows(kRest + 1).isZero(1e-9));
    EXPECT_TRUE(one.a.topRows(kRest).isZero(0.0));
  }
}

}  // namespace
}  // namespace tonus::impedance::test
