#pragma once

#include <Eigen/Core>

#include "analysis_service/impedance/identification.hpp"

namespace tonus::impedance {

/// Columns of a model's velocity term: 2 axes: (3) 2, (13) 0, (14) 3, (15) 2.
[[nodiscard]] constexpr int velocity_terms(Model model, int axes) {
  if (model == Model::kNoDamping) return 0;
  return model == Model::kCoriolis ? axes * (axes + 1) / 2 : axes;
}

/// Length of the regressor [x", velocity terms, x, 1].
[[nodiscard]] constexpr int regressors(Model model, int axes) {
  return 2 * axes + velocity_terms(model, axes) + 1;
}

/// M, B, K, X0 = -K^-1 c from Theta (regressors x axes), F = Theta' phi. A singular K gives an X0 not finite.
[[nodiscard]] Parameters parameters_from(const Eigen::MatrixXd& theta, int axes);

/// All elements in one column: M, B, K column by column, X0; and back, with the shapes of `like`.
[[nodiscard]] Eigen::VectorXd flatten(const Parameters& parameters);
[[nodiscard]] Parameters unflatten(const Eigen::VectorXd& elements, const Parameters& like);

/// Largest magnitude of an element; 0 for an empty matrix.
[[nodiscard]] double largest_element(const AxisMatrix& matrix);

}  // namespace tonus::impedance
