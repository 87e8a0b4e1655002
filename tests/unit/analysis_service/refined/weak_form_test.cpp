#include "analysis_service/refined/weak_form.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace tonus::refined {
namespace {

constexpr double kPeriod = 0.005;
constexpr Eigen::Index kStep = 4;

TEST(WeakForm, GivesTheDerivativesOfAParabolaAtTheMiddleOfEachTestFunction) {
  const WeakForm weak(100, kPeriod, kStep);
  Eigen::MatrixXd x(100, 1);
  for (Eigen::Index k = 0; k < 100; ++k) x(k, 0) = 3.0 * std::pow(kPeriod * static_cast<double>(k), 2);
  const Eigen::MatrixXd rate = weak.apply(1, x);
  const Eigen::MatrixXd acceleration = weak.apply(2, x);
  ASSERT_EQ(weak.size(), (100 - 1 - 24) / 4 + 1);
  for (Eigen::Index i = 0; i < weak.size(); ++i) {
    EXPECT_NEAR(rate(i, 0), 6.0 * kPeriod * static_cast<double>(i * kStep + 12), 1e-9);
    EXPECT_NEAR(acceleration(i, 0), 6.0, 1e-8);
  }
}

TEST(WeakForm, WeighsASineByTheSixthPowerOfItsSinc) {  // the spectrum of a quintic B-spline
  const double w = 2.0 * std::numbers::pi * 7.0;
  Eigen::MatrixXd x(120, 1);
  for (Eigen::Index k = 0; k < 120; ++k) x(k, 0) = std::sin(w * kPeriod * static_cast<double>(k));
  const WeakForm weak(120, kPeriod, kStep);
  const double half = 0.5 * w * kPeriod * kStep;
  const double gain = std::pow(std::sin(half) / half, 6);
  for (Eigen::Index i = 0; i < weak.size(); ++i) {
    const double t = kPeriod * static_cast<double>(i * kStep + 12);
    EXPECT_NEAR(weak.apply(0, x)(i, 0), gain * std::sin(w * t), 1e-6);
    EXPECT_NEAR(weak.apply(1, x)(i, 0) / w, gain * std::cos(w * t), 1e-6);
    EXPECT_NEAR(weak.apply(2, x)(i, 0) / (w * w), -gain * std::sin(w * t), 1e-5);
  }
}

TEST(WeakForm, HasNoTestFunctionWhereTheRowsAreTooFew) { EXPECT_EQ(WeakForm(24, kPeriod, kStep).size(), 0); }

TEST(WeakForm, KeepsTestFunctions20msApartAtEverySamplingRate) {
  EXPECT_EQ(step_of(0.005), 4);
  EXPECT_EQ(step_of(0.001), 20);
  EXPECT_EQ(step_of(0.02), 2);
}

}  // namespace
}  // namespace tonus::refined
