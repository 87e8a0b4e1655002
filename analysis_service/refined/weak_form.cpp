#include "analysis_service/refined/weak_form.hpp"

#include <algorithm>
#include <cmath>

namespace tonus::refined {
namespace {

constexpr int kDegree = 5;
constexpr double kStep = 0.020;  // s

/// The `derivative`-th derivative of the cardinal B-spline at u, in units of its step.
double spline(int derivative, double u) {
  const int degree = kDegree - derivative;
  double factorial = 1.0;
  for (int i = 2; i <= degree; ++i) factorial *= i;
  double binomial = 1.0;  // (-1)^k C(6, k)
  double sum = 0.0;
  for (int k = 0; k <= kDegree + 1 && u > k; ++k) {
    sum += binomial * std::pow(u - k, degree);
    binomial *= -static_cast<double>(kDegree + 1 - k) / (k + 1);
  }
  return sum / factorial;
}

}  // namespace

Eigen::Index step_of(double sample_period) {
  return std::max<Eigen::Index>(2, std::llround(kStep / sample_period));
}

WeakForm::WeakForm(Eigen::Index rows, double sample_period, Eigen::Index step) : step_(step) {
  const Eigen::Index span = (kDegree + 1) * step;
  size_ = rows > span ? (rows - 1 - span) / step + 1 : 0;
  double sum = 0.0;
  for (int derivative = 0; derivative <= 2; ++derivative) {
    Eigen::VectorXd& weights = weights_[static_cast<std::size_t>(derivative)];
    weights.resize(span + 1);
    for (Eigen::Index i = 0; i <= span; ++i)
      weights[i] = spline(derivative, static_cast<double>(i) / static_cast<double>(step));
    if (derivative == 0) sum = weights.sum();
    weights *= std::pow(-1.0 / (static_cast<double>(step) * sample_period), derivative) / sum;
  }
}

Eigen::MatrixXd WeakForm::apply(int derivative, const Eigen::MatrixXd& signal) const {
  const Eigen::VectorXd& weights = weights_[static_cast<std::size_t>(derivative)];
  Eigen::MatrixXd out(size_, signal.cols());
  for (Eigen::Index column = 0; column < signal.cols(); ++column) {
    for (Eigen::Index i = 0; i < size_; ++i)
      out(i, column) = weights.dot(signal.col(column).segment(i * step_, weights.size()));
  }
  return out;
}

}  // namespace tonus::refined
