#include "analysis_service/impedance/optimal_fourier.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "analysis_service/impedance/fit_signals.hpp"
#include "tests/unit/analysis_service/impedance/reference_vectors.hpp"

namespace tonus::impedance::test {
namespace {

TEST(OptimalFourier, HasTheSineCoefficientsOfScipysTransform) {
  const auto trials = reference_trials();
  EXPECT_LT(difference(sine_coefficients(trials[0].displacement.col(0)),
                       reference("scipy.txt", "sine_coefficients")),
            1e-9);
}

TEST(OptimalFourier, FindsTheRegularisationThatBrentsMethodFinds) {
  const Eigen::MatrixXd expected = reference("scipy.txt", "mu");  // Rows rho = 1, 2; columns p = 2, 3.
  const auto trials = reference_trials();
  const Eigen::VectorXd b = sine_coefficients(trials[0].displacement.col(0));
  const double duration = 119 * 0.005;
  for (int row = 0; row < 2; ++row) {
    for (int p = 2; p <= 3; ++p) {
      const double mu = regularisation(b, duration, p, 1.0 + row);
      EXPECT_NEAR(mu / expected(row, p - 2), 1.0, 1e-9) << "rho " << 1 + row << " p " << p;
    }
  }
}

TEST(OptimalFourier, EqualsScipysSeriesAndItsDerivatives) {
  const auto trials = reference_trials();
  const Eigen::MatrixXd expected = reference("scipy.txt", "optimal");
  Options options;
  options.method = Method::kOptimal;
  const FitSignals signals = fit_signals(trials[0], options, 0.0);
  EXPECT_LT(difference(signals.acceleration, expected.leftCols(2)), 1e-9);
  EXPECT_LT(difference(signals.velocity_terms, expected.middleCols(2, 2)), 1e-9);
  EXPECT_LT(difference(signals.displacement, expected.middleCols(4, 2)), 1e-9);
}

TEST(OptimalFourier, RecoversTheDerivativesOfASineUnderWhiteNoise) {
  // x = sin(2 pi t) over 2 s vanishes at both ends; its derivatives are known in closed form.
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0.0, 0.01);
  const double w = 2.0 * std::numbers::pi;
  Eigen::VectorXd x(401);
  for (Eigen::Index k = 0; k < x.size(); ++k)
    x[k] = std::sin(w * 0.005 * static_cast<double>(k)) + noise(random);

  const OptimalDerivatives d = optimal_fourier(x, 0.005);

  for (Eigen::Index k = 40; k < 361; ++k) {
    const double t = 0.005 * static_cast<double>(k);
    EXPECT_NEAR(d.value(k, 0), std::sin(w * t), 0.01);
    EXPECT_NEAR(d.rate(k, 0), w * std::cos(w * t), 0.05 * w);
    EXPECT_NEAR(d.acceleration(k, 0), -w * w * std::sin(w * t), 0.08 * w * w);
  }
}

TEST(OptimalFourier, GivesALineBackExactly) {
  const Eigen::VectorXd line = Eigen::VectorXd::LinSpaced(50, 1.0, 3.0);
  const OptimalDerivatives d = optimal_fourier(line, 0.01);
  EXPECT_LT((d.value - line).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((d.rate.array() - 2.0 / 0.49).abs().maxCoeff(), 1e-9);
  EXPECT_LT(d.acceleration.cwiseAbs().maxCoeff(), 1e-6);
}

}  // namespace
}  // namespace tonus::impedance::test
