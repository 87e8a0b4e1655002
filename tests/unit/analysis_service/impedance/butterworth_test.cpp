#include "analysis_service/impedance/butterworth.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "analysis_service/impedance/fit_signals.hpp"
#include "tests/unit/analysis_service/impedance/reference_vectors.hpp"

namespace tonus::impedance::test {
namespace {

constexpr double kPeriod = 0.005;

TEST(Butterworth, EqualsScipyFiltfiltAndNumpyDifferences) {
  const auto trials = reference_trials();
  const Eigen::MatrixXd expected = reference("scipy.txt", "lowpass");  // x"(2), x'(2), x(2), f(2)

  const Signals x = zero_phase(butterworth_lowpass(10.0, kPeriod), trials[0].displacement);

  EXPECT_LT(difference(x, expected.middleCols(4, 2)), 1e-9);
  EXPECT_LT(difference(central_difference(x, kPeriod), expected.middleCols(2, 2)), 1e-9);
  EXPECT_LT(difference(second_difference(x, kPeriod), expected.leftCols(2)), 1e-9);
}

TEST(Butterworth, HalvesThePowerOfASineAtTheCutoffInEachOfTwoRuns) {
  const double cutoff = 8.0;
  Eigen::VectorXd sine(2000);
  for (Eigen::Index k = 0; k < sine.size(); ++k) {
    sine[k] = std::sin(2.0 * std::numbers::pi * cutoff * static_cast<double>(k) * kPeriod);
  }

  const Signals out = zero_phase(butterworth_lowpass(cutoff, kPeriod), sine);

  // Away from the ends the output is half the input: no phase shift, gain 1/sqrt(2) squared.
  EXPECT_LT((out.col(0).segment(500, 1000) - 0.5 * sine.segment(500, 1000)).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(Butterworth, LeavesAStraightLineAsItIs) {
  const Eigen::VectorXd line = Eigen::VectorXd::LinSpaced(100, -3.0, 4.0);
  EXPECT_LT(difference(zero_phase(butterworth_lowpass(10.0, kPeriod), line).middleRows(20, 60),
                       line.segment(20, 60)),
            1e-3);
  EXPECT_LT(second_difference(line, kPeriod).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Butterworth, FiltersTheForceOnlyWhenAsked) {
  const auto trials = reference_trials();
  Options options;
  options.method = Method::kLowpass;
  EXPECT_EQ(fit_signals(trials[0], options, 0.0).force, trials[0].force);
  options.is_force_filtered = true;
  EXPECT_EQ(fit_signals(trials[0], options, 0.0).force,
            zero_phase(butterworth_lowpass(10.0, kPeriod), trials[0].force));
}

}  // namespace
}  // namespace tonus::impedance::test
