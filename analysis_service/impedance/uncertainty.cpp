#include "analysis_service/impedance/uncertainty.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tonus::impedance {
namespace {

template <typename E>
auto& entry(E& estimate, AxisMatrix Parameters::*matrix) {
  if (matrix == &Parameters::M) return estimate.uncertainty.M;
  return matrix == &Parameters::B ? estimate.uncertainty.B : estimate.uncertainty.K;
}

}  // namespace

void set_uncertainty(AxisMatrix Parameters::*matrix, const Eigen::MatrixXd& covariance,
                     const SpreadOf& spread_of, double freedom, Estimate& estimate) {
  MatrixUncertainty& uncertainty = uncertainty_of(estimate, matrix);
  uncertainty.covariance = covariance;
  uncertainty.freedom = freedom;
  uncertainty.ellipse.reset();
  const AxisMatrix& value = estimate.value.*matrix;
  if (value.rows() != 2 || value.cols() != 2) return;
  uncertainty.ellipse = ellipse_intervals(Eigen::Matrix2d(value), Eigen::Matrix4d(covariance), spread_of);
}

void set_uncertainty_of_theta(const Eigen::MatrixXd& covariance, const ThetaSpreadOf& spread_of,
                              Estimate& estimate) {
  const Eigen::Index axes = estimate.axes;
  const Eigen::Index q = covariance.rows() / axes;
  const auto set = [&](AxisMatrix Parameters::*matrix, Eigen::Index first) {
    const Eigen::Index columns = (estimate.value.*matrix).cols();
    if (columns != axes) return;  // not the model's, or no matrix of the axes
    std::vector<Eigen::Index> places;
    for (Eigen::Index i = 0; i < axes; ++i) {
      for (Eigen::Index j = 0; j < axes; ++j) places.push_back(i * q + first + j);
    }
    double freedom = 1e9;
    for (const Eigen::Index place : places)
      freedom = std::min(freedom, spread_of(Eigen::VectorXd::Unit(covariance.rows(), place)).freedom);
    const SpreadOf of_elements = [&](const Eigen::Vector4d& weights) {
      Eigen::VectorXd all = Eigen::VectorXd::Zero(covariance.rows());
      for (std::size_t i = 0; i < places.size(); ++i) all[places[i]] = weights[static_cast<Eigen::Index>(i)];
      return spread_of(all);
    };
    set_uncertainty(matrix, covariance(places, places), of_elements, freedom, estimate);
  };
  set(&Parameters::M, 0);
  set(&Parameters::B, axes);
  set(&Parameters::K, q - 1 - axes);
}

MatrixUncertainty& uncertainty_of(Estimate& estimate, AxisMatrix Parameters::*matrix) {
  return entry(estimate, matrix);
}

const MatrixUncertainty& uncertainty_of(const Estimate& estimate, AxisMatrix Parameters::*matrix) {
  return entry(estimate, matrix);
}

}  // namespace tonus::impedance
