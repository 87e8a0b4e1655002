#include "analysis_service/impedance/belief.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace tonus::impedance::test {
namespace {

Belief belief(double value, double std, double freedom = 1e6) {
  return {Eigen::VectorXd::Constant(1, value), Eigen::MatrixXd::Constant(1, 1, std * std), freedom};
}

TEST(Belief, CombinesByInverseVariances) {
  const Combined found = combine(belief(400.0, 30.0), belief(340.0, 40.0));
  // Closed form: weights 1600 and 900 of 2500; variance 900 * 1600 / 2500.
  EXPECT_NEAR(found.belief.value[0], 400.0 * 0.64 + 340.0 * 0.36, 1e-9);
  EXPECT_NEAR(found.std[0], 24.0, 1e-9);
  EXPECT_NEAR(found.half[0], 1.959964 * 24.0, 1e-3);
  EXPECT_NEAR(found.apart, 60.0 / (1.959964 * 50.0), 1e-4);
}

TEST(Belief, OfAVaguePriorLeavesTheEstimate) {
  const Combined found = combine(belief(400.0, 30.0, 15.0), belief(0.0, 1e6));
  EXPECT_NEAR(found.belief.value[0], 400.0, 1e-3);
  EXPECT_NEAR(found.half[0] / found.std[0], 2.131450, 1e-4);  // Student's t with 15 degrees of freedom
}

TEST(Belief, OfACohortIsItsMeanAndWhatTheNextOneMayDifferBy) {
  Eigen::MatrixXd values(1, 4);
  values << 1.0, 2.0, 3.0, 4.0;
  const Belief found = belief_of_many(values);
  EXPECT_NEAR(found.value[0], 2.5, 1e-12);
  EXPECT_NEAR(found.covariance(0, 0), 5.0 / 3.0 * 1.25, 1e-12);
  EXPECT_EQ(found.freedom, 3.0);
}

}  // namespace
}  // namespace tonus::impedance::test
