#include "analysis_service/refined/residual_process.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace tonus::refined {
namespace {

/// e(t) = a e(t-1) + w, w of unit variance.
std::vector<Eigen::MatrixXd> first_order(double a, std::size_t trials, Eigen::Index n) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::vector<Eigen::MatrixXd> all;
  for (std::size_t j = 0; j < trials; ++j) {
    Eigen::MatrixXd e(n, 1);
    double last = normal(random) / std::sqrt(1.0 - a * a);
    for (Eigen::Index t = 0; t < n; ++t) e(t, 0) = last = a * last + normal(random);
    all.push_back(std::move(e));
  }
  return all;
}

TEST(ResidualProcess, FindsTheCoefficientAndVarianceOfAFirstOrderProcess) {
  const auto e = first_order(0.8, 40, 200);
  const ResidualProcess process = fit_process(e, 1);
  EXPECT_NEAR(process.A[0](0, 0), 0.8, 0.02);
  EXPECT_NEAR(process.S(0, 0), 1.0, 0.05);
  EXPECT_NEAR(process.state(0, 0), process.S(0, 0) / (1.0 - std::pow(process.A[0](0, 0), 2)), 1e-9);
}

TEST(ResidualProcess, ChoosesALowOrderForAFirstOrderProcessAndAtLeastThat) {
  const Eigen::Index order = chosen_order(first_order(0.8, 40, 200));
  EXPECT_GE(order, 1);
  EXPECT_LE(order, 3);
}

TEST(ResidualProcess, MeanOfAFirstOrderProcessHasTheVarianceOfItsClosedForm) {
  ResidualProcess process;
  const double a = 0.7;
  process.A = {Eigen::MatrixXd::Constant(1, 1, a)};
  process.S = Eigen::MatrixXd::Ones(1, 1);
  process.state = Eigen::MatrixXd::Constant(1, 1, 1.0 / (1.0 - a * a));
  const double n = 50.0;
  const double expected =
      (n * (1.0 + a) / (1.0 - a) - 2.0 * a * (1.0 - std::pow(a, n)) / ((1.0 - a) * (1.0 - a))) /
      (1.0 - a * a) / (n * n);
  EXPECT_NEAR(covariance_of_mean(process, 50)(0, 0), expected, 1e-12);
}

TEST(ResidualProcess, BringsAPoleOutsideTheCircleBackIn) {
  std::vector<Eigen::MatrixXd> growing(2, Eigen::MatrixXd(60, 1));
  for (auto& e : growing) {
    for (Eigen::Index t = 0; t < 60; ++t) e(t, 0) = std::pow(1.1, static_cast<double>(t));
  }
  const ResidualProcess process = fit_process(growing, 1);
  EXPECT_LE(process.A[0](0, 0), 0.9951);
}

}  // namespace
}  // namespace tonus::refined
