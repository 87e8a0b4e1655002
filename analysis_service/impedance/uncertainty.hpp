#pragma once

#include <Eigen/Core>
#include <functional>

#include "analysis_service/impedance/identification.hpp"

namespace tonus::impedance {

/// Spread of the combination of vec(Theta) with these weights.
using ThetaSpreadOf = std::function<CombinationSpread(const Eigen::VectorXd& weights)>;

/// Sets `uncertainty` of the matrices of an estimate whose values are set, from the covariance of vec(Theta),
/// column by column (one column an axis, its rows x", velocity terms, x, 1).
void set_uncertainty_of_theta(const Eigen::MatrixXd& covariance, const ThetaSpreadOf& spread_of,
                              Estimate& estimate);

/// Sets that of one matrix from the covariance of its elements, row by row.
void set_uncertainty(AxisMatrix Parameters::*matrix, const Eigen::MatrixXd& covariance,
                     const SpreadOf& spread_of, double freedom, Estimate& estimate);

/// By matrix.
[[nodiscard]] MatrixUncertainty& uncertainty_of(Estimate& estimate, AxisMatrix Parameters::*matrix);
[[nodiscard]] const MatrixUncertainty& uncertainty_of(const Estimate& estimate,
                                                      AxisMatrix Parameters::*matrix);

}  // namespace tonus::impedance
