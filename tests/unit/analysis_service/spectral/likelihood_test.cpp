#include "analysis_service/spectral/likelihood.hpp"

#include <gtest/gtest.h>
#include <random>

namespace tonus::spectral {
namespace {

template <int N>
void expect_gradient_of_value() {
  using Model = Likelihood<N>;
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  const Eigen::ArrayXd w = Eigen::ArrayXd::LinSpaced(9, 0.4, 2.0);
  Model likelihood(w, 3.0);
  typename Model::Data data;
  data.segments = 30.0;
  for (Eigen::Index k = 0; k < w.size(); ++k) {
    typename Model::Moment moment = Model::Moment::Zero();
    for (int s = 0; s < 30; ++s) {
      Eigen::Matrix<std::complex<double>, 4 * N, 1> y;
      for (auto& value : y) value = {normal(random), normal(random)};
      moment += y * y.adjoint();
    }
    data.moments.push_back(moment);
  }
  typename Model::Vector p;
  for (auto& value : p) value = 0.5 * normal(random);
  likelihood.centre_noise(p * 0.9);
  const auto slope = likelihood.gradient(p, data);
  for (int i = 0; i < Model::kParameters; ++i) {
    constexpr double kStep = 1e-6;
    typename Model::Vector up = p;
    typename Model::Vector down = p;
    up[i] += kStep;
    down[i] -= kStep;
    const double difference = (likelihood.value(up, data) - likelihood.value(down, data)) / (2.0 * kStep);
    EXPECT_NEAR(slope[i], difference, 1e-5 * (1.0 + std::abs(difference))) << "parameter " << i;
  }
}

TEST(Likelihood, GradientIsThatOfItsValueOnOneAxis) { expect_gradient_of_value<1>(); }
TEST(Likelihood, GradientIsThatOfItsValueOnTwoAxes) { expect_gradient_of_value<2>(); }

TEST(Likelihood, GradientOfBandsAddsUp) {
  using Model = Likelihood<1>;
  const Eigen::ArrayXd w = Eigen::ArrayXd::LinSpaced(6, 0.5, 1.5);
  const Model likelihood(w, 1.0);
  typename Model::Data data;
  data.segments = 1.0;
  for (int k = 0; k < 6; ++k) {
    Eigen::Matrix<std::complex<double>, 4, 1> y;
    y << 1.0 + k, 2.0, 0.5 * k, 1.0;
    data.moments.push_back(y * y.adjoint() + Model::Moment::Identity());
  }
  const Model::Vector p = Model::Vector::Constant(0.3);
  const Model::Vector sum = likelihood.gradient(p, data, 0, 2) + likelihood.gradient(p, data, 2, 6);
  EXPECT_LT((sum - likelihood.gradient(p, data)).norm(), 1e-12 * sum.norm());
}

}  // namespace
}  // namespace tonus::spectral
