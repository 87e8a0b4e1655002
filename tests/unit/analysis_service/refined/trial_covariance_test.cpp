#include "analysis_service/refined/trial_covariance.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>

namespace tonus::refined {
namespace {

/// `trials` of one constant each; its fit is their mean.
WeightedFit mean_of(const Eigen::VectorXd& values, Eigen::Index rows) {
  WeightedFit fit;
  fit.theta = Eigen::MatrixXd::Constant(1, 1, values.mean());
  fit.ZX = Eigen::MatrixXd::Constant(1, 1, static_cast<double>(values.size() * rows));
  for (const double value : values) {
    fit.y.emplace_back(Eigen::VectorXd::Constant(rows, value));
    fit.X.emplace_back(Eigen::MatrixXd::Ones(rows, 1));
    fit.Z.emplace_back(Eigen::MatrixXd::Ones(rows, 1));
  }
  return fit;
}

TEST(TrialCovariance, OfAMeanIsTheVarianceOfTrialsOverTheirNumberWithOneDegreeOfFreedomLess) {
  const Eigen::VectorXd values = (Eigen::VectorXd(5) << 1.0, 4.0, -2.0, 0.5, 3.0).finished();
  const TrialCovariance covariance(mean_of(values, 7));
  const double variance = (values.array() - values.mean()).square().sum() / 4.0;
  const Spread spread = covariance.spread_of(Eigen::VectorXd::Ones(1));
  EXPECT_NEAR(spread.std, std::sqrt(variance / 5.0), 1e-12);
  EXPECT_NEAR(spread.freedom, 4.0, 1e-9);
}

TEST(TrialCovariance, DoesNotTakeRepeatedSamplesOfATrialForMoreTrials) {
  const Eigen::VectorXd values = (Eigen::VectorXd(4) << 1.0, 2.0, 0.0, 5.0).finished();
  const Spread few = TrialCovariance(mean_of(values, 2)).spread_of(Eigen::VectorXd::Ones(1));
  const Spread many = TrialCovariance(mean_of(values, 200)).spread_of(Eigen::VectorXd::Ones(1));
  EXPECT_NEAR(few.std, many.std, 1e-12);
}

}  // namespace
}  // namespace tonus::refined
