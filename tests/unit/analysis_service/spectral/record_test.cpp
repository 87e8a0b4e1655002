#include "analysis_service/spectral/record.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace tonus::spectral {
namespace {

TEST(FastLength, IsEvenAndHasNoPrimeFactorAboveFive) {
  EXPECT_EQ(fast_length(7), 8);
  EXPECT_EQ(fast_length(11), 12);
  EXPECT_EQ(fast_length(59'999), 60'000);
  EXPECT_EQ(fast_length(61), 64);
  EXPECT_EQ(fast_length(15), 16);
}

TEST(Record, IsFilledByStraightLinesOverGapsAndWithoutItsMean) {
  Record record{
      0.001, Eigen::MatrixXd(6, 1), Eigen::MatrixXd::Zero(6, 1), {false, true, true, false, false, true}};
  record.displacement.col(0) << 0.0, std::nan(""), std::nan(""), 3.0, 6.0, std::nan("");
  const Record whole = filled(record);
  const double mean = 3.0;  // of 0, 3 and 6
  EXPECT_DOUBLE_EQ(whole.displacement(0, 0), 0.0 - mean);
  EXPECT_DOUBLE_EQ(whole.displacement(1, 0), 1.0 - mean);
  EXPECT_DOUBLE_EQ(whole.displacement(2, 0), 2.0 - mean);
  EXPECT_DOUBLE_EQ(whole.displacement(5, 0), 6.0 - mean);
}

TEST(Record, ForceIsAdvancedByAFractionOfASample) {
  constexpr Eigen::Index kRows = 2000;
  constexpr double kLead = 0.00137;
  Record record{0.001, Eigen::MatrixXd::Zero(kRows, 1), Eigen::MatrixXd(kRows, 1), {}};
  const auto force = [](double t) { return std::exp(-std::pow((t - 1.0) / 0.1, 2)) * std::sin(300.0 * t); };
  for (Eigen::Index i = 0; i < kRows; ++i) record.force(i, 0) = force(0.001 * static_cast<double>(i));
  const Record advanced = with_force_advanced(record, Eigen::VectorXd::Constant(1, kLead));
  for (Eigen::Index i = 100; i < kRows - 100; ++i)
    ASSERT_NEAR(advanced.force(i, 0), force(0.001 * static_cast<double>(i) + kLead), 1e-9) << i;
}

}  // namespace
}  // namespace tonus::spectral
