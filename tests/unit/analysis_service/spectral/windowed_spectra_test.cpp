#include "analysis_service/spectral/windowed_spectra.hpp"

#include <cmath>
#include <complex>
#include <gtest/gtest.h>
#include <numbers>

namespace tonus::spectral {
namespace {

TEST(Segments, LieBetweenTheGaps) {
  Record record{0.001, Eigen::MatrixXd::Zero(1000, 1), Eigen::MatrixXd::Zero(1000, 1),
                std::vector<bool>(1000)};
  record.is_missing[400] = true;
  const auto segments = segments_of({&record, 1}, 200);
  ASSERT_FALSE(segments.empty());
  bool is_any_behind = false;
  for (const Segment& segment : segments) {
    EXPECT_TRUE(segment.first + 200 <= 400 || segment.first > 400) << segment.first;
    is_any_behind |= segment.first == 401;
  }
  EXPECT_TRUE(is_any_behind) << "the first one behind the gap begins right behind it";
}

// A sine of any frequency, an offset and a trend: the windowed spectrum of its derivatives is known in closed
// form from the derivatives themselves.
TEST(WindowedSpectra, OfDerivativesAreExactWhateverTheFrequencyAndTheTransient) {
  constexpr Eigen::Index kLength = 400;
  constexpr double kPeriod = 0.001;
  constexpr double kW = 2.0 * std::numbers::pi * 173.3;  // 0.17 of the rate, between two bins
  Record record{kPeriod, Eigen::MatrixXd(kLength, 1), Eigen::MatrixXd(kLength, 1), {}};
  Record rates = record;  // x' and x" in place of displacement and force
  for (Eigen::Index i = 0; i < kLength; ++i) {
    const double t = kPeriod * static_cast<double>(i);
    record.displacement(i, 0) = 7.0 + 3.0 * t + std::sin(kW * t + 0.4);
    record.force(i, 0) = kW * std::cos(kW * t + 0.4) + 3.0;
    rates.displacement(i, 0) = 0.0;
    rates.force(i, 0) = -kW * kW * std::sin(kW * t + 0.4);
  }
  const Segment segment{0, 0};
  const Bins bins{20, 150};
  const auto Y = windowed_spectra({&record, 1}, {&segment, 1}, kLength, bins);
  const auto A = windowed_spectra({&rates, 1}, {&segment, 1}, kLength, bins);
  ASSERT_EQ(Y.size(), 1U);
  const double largest_rate = Y[0].row(2).cwiseAbs().maxCoeff();
  const double largest_acceleration = Y[0].row(1).cwiseAbs().maxCoeff();
  for (Eigen::Index k = 0; k < Y[0].cols(); ++k) {
    EXPECT_LT(std::abs(Y[0](2, k) - Y[0](0, k)), 1e-9 * largest_rate) << k;
    EXPECT_LT(std::abs(Y[0](1, k) - A[0](0, k)), 1e-9 * largest_acceleration) << k;
  }
}

TEST(WindowedSpectra, OffsetDoesNotReachTheBinsThatAreFitted) {
  Record record{0.001, Eigen::MatrixXd::Constant(256, 1, 5.0), Eigen::MatrixXd::Constant(256, 1, 9.0), {}};
  record.displacement(0, 0) = 5.0;
  const Segment segment{0, 0};
  const auto Y = windowed_spectra({&record, 1}, {&segment, 1}, 256, {3, 100});
  EXPECT_LT(Y[0].row(0).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT(Y[0].row(3).cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace
}  // namespace tonus::spectral
