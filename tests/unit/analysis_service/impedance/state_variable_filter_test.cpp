#include "analysis_service/impedance/state_variable_filter.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "analysis_service/impedance/fit_signals.hpp"
#include "tests/unit/analysis_service/impedance/reference_vectors.hpp"

namespace tonus::impedance::test {
namespace {

Eigen::MatrixXd all_columns(const FitSignals& s) {
  Eigen::MatrixXd columns(s.force.rows(), 8);
  columns << s.acceleration, s.velocity_terms, s.displacement, s.force;
  return columns;
}

TEST(StateVariableFilter, EqualsScipyLsimWithInterpolatedInput) {
  const auto trials = reference_trials();
  const FitSignals signals = fit_signals(trials[0], Options{}, 2.3);
  const Eigen::MatrixXd expected = reference("scipy.txt", "state_variable");
  for (Eigen::Index column = 0; column < 8; ++column) {
    EXPECT_LT(difference(all_columns(signals).col(column), expected.col(column)), 1e-9)
        << "column " << column;
  }
}

TEST(StateVariableFilter, EqualsOctavesMatrixExponential) {
  const auto trials = reference_trials();
  const FitSignals signals = fit_signals(trials[0], Options{}, 2.3);
  const Eigen::MatrixXd expected = reference("octave.txt", "state_variable");
  for (Eigen::Index column = 0; column < 8; ++column) {
    EXPECT_LT(difference(all_columns(signals).col(column), expected.col(column)), 1e-9)
        << "column " << column;
  }
}

TEST(StateVariableFilter, FollowsTheClosedFormOfARamp) {
  // Response of (8) to u = t from rest: y = t - 2 zeta/wn + exp(-zeta wn t)(2 zeta/wn cos wd t +
  // (2 zeta^2 - 1)/wd sin wd t). A ramp is its own first-order hold, so the samples are exact.
  const double f = 2.0;
  const double zeta = 0.1;
  const double h = 0.005;
  const double wn = 2.0 * std::numbers::pi * f;
  const double wd = wn * std::sqrt(1.0 - zeta * zeta);
  StateVariableFilter<1> filter(StateVariableStep::make(f, zeta, h));
  for (int k = 0; k < 400; ++k) {
    const double t = k * h;
    filter.push(Eigen::Array<double, 1, 1>(t));
    const double decay = std::exp(-zeta * wn * t);
    const double y =
        t - 2.0 * zeta / wn +
        decay * (2.0 * zeta / wn * std::cos(wd * t) + (2.0 * zeta * zeta - 1.0) / wd * std::sin(wd * t));
    EXPECT_NEAR(filter.value()[0], y, 1e-12);
    const double impulse = wn * wn / wd * decay * std::sin(wd * t);  // y" of a ramp is the impulse response.
    EXPECT_NEAR(filter.acceleration()[0], impulse, 1e-9);
  }
}

TEST(StateVariableFilter, PassesAConstantUnchangedInTheSteadyState) {
  StateVariableFilter<1> filter(StateVariableStep::make(2.0, 0.1, 0.005));
  for (int k = 0; k < 10000; ++k) filter.push(Eigen::Array<double, 1, 1>(3.0));
  EXPECT_NEAR(filter.value()[0], 3.0, 1e-12);
  EXPECT_NEAR(filter.rate()[0], 0.0, 1e-10);
  EXPECT_NEAR(filter.acceleration()[0], 0.0, 1e-8);
}

TEST(StateVariableFilter, KeepsABiasForceOutOfTheTransient) {
  // A loaded trial at rest: the bias stands in the force from the first sample on.
  Trial trial;
  trial.sample_period = 0.005;
  trial.onset = 50;
  trial.displacement = Signals::Zero(100, 2);
  trial.force = Signals::Constant(100, 2, 0.8);
  const FitSignals signals = fit_signals(trial, Options{}, 2.0);
  EXPECT_LT((signals.force.array() - 0.8).abs().maxCoeff(), 1e-14);
}

}  // namespace
}  // namespace tonus::impedance::test
