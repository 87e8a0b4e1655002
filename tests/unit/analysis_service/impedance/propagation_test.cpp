#include "analysis_service/impedance/propagation.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace tonus::impedance::test {
namespace {

UncertainPosture posture(double mass, double std, double freedom) {
  UncertainPosture one;
  one.value.impedance.M = mass * Eigen::Matrix2d::Identity();
  one.covariance = Eigen::MatrixXd::Zero(12, 12);
  one.covariance(0, 0) = std * std;
  one.freedom = freedom;
  return one;
}

std::optional<Eigen::VectorXd> mean_of_first(std::span<const PostureImpedance> postures) {
  double sum = 0.0;
  for (const PostureImpedance& one : postures) sum += one.impedance.M(0, 0);
  return Eigen::VectorXd::Constant(1, sum / static_cast<double>(postures.size()));
}

TEST(Propagation, OfAMeanOfTwoIsWelchsInterval) {
  const std::vector<UncertainPosture> two{posture(1.0, 0.3, 7.0), posture(3.0, 0.4, 7.0)};
  const auto found = propagate(two, mean_of_first);
  ASSERT_EQ(found.size(), 1U);
  // Standard error 0.25; freedom 0.25^2 / (0.09^2 + 0.16^2) * 7 = 12.98, t = 2.1609 by R's qt(.975, 12.98).
  EXPECT_NEAR(0.5 * (found[0].low + found[0].high), 2.0, 1e-9);
  EXPECT_NEAR(0.5 * (found[0].high - found[0].low), 2.1608 * 0.25, 2e-4);
}

TEST(Propagation, CarriesTheKnownBias) {
  std::vector<UncertainPosture> two{posture(1.0, 0.3, 7.0), posture(3.0, 0.4, 7.0)};
  const auto without = propagate(two, mean_of_first);
  two[0].bias.M(0, 0) = -0.5;
  const auto with = propagate(two, mean_of_first);
  EXPECT_EQ(with[0].low, without[0].low);
  EXPECT_NEAR(with[0].high, without[0].high + 0.25, 1e-9);
}

TEST(Propagation, GivesNothingWhereTheNumbersCannotBeComputed) {
  const std::vector<UncertainPosture> one{posture(1.0, 0.3, 7.0)};
  EXPECT_TRUE(propagate(one, [](std::span<const PostureImpedance>) { return std::nullopt; }).empty());
}

}  // namespace
}  // namespace tonus::impedance::test
