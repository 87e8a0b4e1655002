#pragma once

#include <Eigen/Core>
#include <array>

namespace tonus::refined {

/// Derivatives of a sampled signal without differencing: the weak form (2).
///
/// Law: for a test function phi that vanishes with its derivatives at its ends, the integral of phi x^(k)
/// equals
/// (-1)^k times the integral of phi^(k) x. phi is a quintic B-spline of 6 `step` rows; one starts every
/// `step` rows. What comes out is the k-th derivative, smoothed by phi, which integrates to 1. The spectrum
/// of phi has zeros of order six at the multiples of the frequency 1/step, so that the sum over rows equals
/// the integral but for what moves within four rows.
class WeakForm {
 public:
  /// `rows` of the signals, `sample_period` (s), `step` of at least one row.
  WeakForm(Eigen::Index rows, double sample_period, Eigen::Index step);

  /// Test functions that fit into the rows; 0 where there are too few.
  [[nodiscard]] Eigen::Index size() const { return size_; }

  /// Derivative 0, 1 or 2 of each column (rows x columns), size() x columns.
  [[nodiscard]] Eigen::MatrixXd apply(int derivative, const Eigen::MatrixXd& signal) const;

 private:
  Eigen::Index step_ = 1;
  Eigen::Index size_ = 0;
  std::array<Eigen::VectorXd, 3> weights_;  // by derivative
};

/// Rows from test function to test function: 20 ms, at least two rows. A quintic spline of that step passes
/// what an arm does (half power at 14 Hz).
[[nodiscard]] Eigen::Index step_of(double sample_period);

}  // namespace tonus::refined
