#pragma once

#include <Eigen/Core>

#include "analysis_service/impedance/fit_signals.hpp"
#include "analysis_service/impedance/recursive_least_squares.hpp"

namespace tonus::impedance {

/// Adds row k of the model: phi = [x", velocity terms, x, 1], output F.
template <int kSize, int kAxes>
void add_row(const FitSignals& signals, Eigen::Index k, RecursiveLeastSquares<kSize, kAxes>& factor) {
  Eigen::Matrix<double, kSize, 1> phi;
  phi << signals.acceleration.row(k).transpose(), signals.velocity_terms.row(k).transpose(),
      signals.displacement.row(k).transpose(), 1.0;
  factor.update(phi, signals.force.row(k).transpose());
}

/// Factor of `rows` rows from row `first` on.
template <int kSize, int kAxes>
[[nodiscard]] RecursiveLeastSquares<kSize, kAxes> factor_of(const FitSignals& signals, Eigen::Index first,
                                                            Eigen::Index rows) {
  RecursiveLeastSquares<kSize, kAxes> factor;
  for (Eigen::Index k = first; k < first + rows; ++k) add_row(signals, k, factor);
  return factor;
}

}  // namespace tonus::impedance
