#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "analysis_service/impedance/fit_signals.hpp"
#include "analysis_service/impedance/recursive_least_squares.hpp"

namespace tonus::impedance {

/// Row k of the model: [phi' F'], phi = [x", velocity terms, x, 1].
template <int kSize, int kAxes>
[[nodiscard]] Eigen::Matrix<double, 1, kSize + kAxes> model_row(const FitSignals& signals, Eigen::Index k) {
  Eigen::Matrix<double, 1, kSize + kAxes> row;
  row << signals.acceleration.row(k), signals.velocity_terms.row(k), signals.displacement.row(k), 1.0,
      signals.force.row(k);
  return row;
}

/// Adds `count` rows of the model, row_at(i) being the ith, in blocks.
template <int kSize, int kAxes, typename RowAt>
void add_rows(Eigen::Index count, const RowAt& row_at, RecursiveLeastSquares<kSize, kAxes>& factor) {
  using Factor = RecursiveLeastSquares<kSize, kAxes>;
  for (Eigen::Index first = 0; first < count; first += Factor::kBlockRows) {
    const Eigen::Index rows = std::min<Eigen::Index>(Factor::kBlockRows, count - first);
    typename Factor::Block block = Factor::Block::Zero();
    for (Eigen::Index i = 0; i < rows; ++i) block.row(i) = row_at(first + i);
    factor.update(block, rows);
  }
}

/// Factor of `rows` rows from row `first` on.
template <int kSize, int kAxes>
[[nodiscard]] RecursiveLeastSquares<kSize, kAxes> factor_of(const FitSignals& signals, Eigen::Index first,
                                                            Eigen::Index rows) {
  RecursiveLeastSquares<kSize, kAxes> factor;
  add_rows(
      rows, [&](Eigen::Index i) { return model_row<kSize, kAxes>(signals, first + i); }, factor);
  return factor;
}

}  // namespace tonus::impedance
