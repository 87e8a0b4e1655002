#include "analysis_service/impedance/tuning.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "tests/support/impedance/linear_rig.hpp"
#include "tests/unit/analysis_service/impedance/reference_vectors.hpp"

namespace tonus::impedance::test {
namespace {

TEST(Tuning, FindsTheSamePeaksAsNumpysTransform) {
  const Eigen::MatrixXd expected = reference("scipy.txt", "peak_frequency");
  const auto trials = reference_trials();
  for (std::size_t i = 0; i < trials.size(); ++i) {
    EXPECT_NEAR(peak_frequency(trials[i].displacement, 20, 100, 0.005),
                expected(0, static_cast<Eigen::Index>(i)), 1e-9);
  }
}

TEST(Tuning, TakesTheMeanOverTrajectories) {
  const Eigen::MatrixXd expected = reference("scipy.txt", "peak_frequency");
  const auto trials = reference_trials();
  std::vector<const Trial*> pointers;
  for (const Trial& trial : trials) pointers.push_back(&trial);
  EXPECT_NEAR(tuned_natural_frequency(pointers, 0.5, 2.0), expected.mean(), 1e-9);
}

TEST(Tuning, FindsASineToWithinATwentiethOfTheWindowsResolution) {
  Signals x(400, 1);
  for (Eigen::Index k = 0; k < 400; ++k) {
    x(k, 0) = std::sin(2.0 * std::numbers::pi * 3.3 * 0.005 * static_cast<double>(k));
  }
  EXPECT_NEAR(peak_frequency(x, 0, 400, 0.005), 3.3, 0.05 / 2.0);
}

TEST(Tuning, DoesNotDependOnTheFrame) {
  auto trials = reference_trials();
  const double before = peak_frequency(trials[0].displacement, 20, 100, 0.005);
  Eigen::Matrix2d turn;
  turn << std::cos(0.7), -std::sin(0.7), std::sin(0.7), std::cos(0.7);
  trials[0].displacement *= turn;
  EXPECT_NEAR(peak_frequency(trials[0].displacement, 20, 100, 0.005), before, 1e-9);
}

TEST(Tuning, IsZeroWhereNothingMoves) {
  EXPECT_EQ(peak_frequency(Signals::Constant(200, 2, 0.1), 0, 200, 0.005), 0.0);
}

TEST(Tuning, CutsAContinuousRecordIntoBlocks) {
  Trial record;
  record.sample_period = 0.005;
  record.is_continuous = true;
  record.displacement.resize(800, 1);
  for (Eigen::Index k = 0; k < 800; ++k) {  // 2 Hz in the first half, 6 Hz in the second.
    const double f = k < 400 ? 2.0 : 6.0;
    record.displacement(k, 0) = std::sin(2.0 * std::numbers::pi * f * 0.005 * static_cast<double>(k));
  }
  const Trial* pointer = &record;
  EXPECT_NEAR(tuned_natural_frequency({&pointer, 1}, 1.0, 2.0), 4.0, 0.03);
}

}  // namespace
}  // namespace tonus::impedance::test
