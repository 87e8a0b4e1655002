#include "analysis_service/refined/command_response.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace tonus::refined {
namespace {

constexpr double kPeriod = 0.005;
constexpr Eigen::Index kRest = 60;

/// Step of 1 m between rows kRest - 1 and kRest of a damped oscillator, from its closed form.
double step_response(double t, double w, double zeta) {
  if (t <= 0.0) return 0.0;
  const double damped = w * std::sqrt(1.0 - zeta * zeta);
  return 1.0 - std::exp(-zeta * w * t) * (std::cos(damped * t) + zeta * w / damped * std::sin(damped * t));
}

MeanResponse oscillator(double w, double zeta, double late) {
  MeanResponse mean;
  mean.sample_period = kPeriod;
  mean.rest = kRest;
  mean.shape = Eigen::VectorXd::Zero(300);
  mean.shape.tail(300 - kRest).setOnes();
  Eigen::MatrixXd x(300, 1);
  // A straight rise within one row is, but for its curvature, a step at that row's middle.
  for (Eigen::Index k = 0; k < 300; ++k)
    x(k, 0) = step_response(kPeriod * (static_cast<double>(k - kRest) + 0.5) - late, w, zeta);
  mean.of_axis = {x};
  return mean;
}

TEST(CommandResponse, FindsTheStepResponseOfADampedOscillator) {
  const CommandResponse found = command_response(oscillator(16.0, 0.2, 0.0));
  ASSERT_TRUE(found.is_found);
  EXPECT_LT(found.unexplained, 1e-4);
}

TEST(CommandResponse, FindsACommandThatActsLaterThanItIsStated) {
  const CommandResponse found = command_response(oscillator(16.0, 0.2, 0.012));
  EXPECT_LT(found.unexplained, 1e-4);
}

TEST(CommandResponse, SaysSoWhereNothingMoved) {
  MeanResponse still = oscillator(16.0, 0.2, 0.0);
  still.of_axis[0].setZero();
  EXPECT_FALSE(command_response(still).is_found);
}

}  // namespace
}  // namespace tonus::refined
