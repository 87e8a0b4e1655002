#pragma once

#include <Eigen/Core>
#include <cmath>

namespace tonus::impedance {

/// Recursive least squares in square-root information form. For rows (phi, f) seen so far, with Phi, F
/// stacked:
///
///     Q [Phi F] = [R Z; 0 E],   R upper triangular, R Theta = Z,   ||F - Phi Theta||^2 = ||E||^2 per output,
///
/// and each row is rotated into [R Z] by Givens rotations. It starts at R = 0 (no prior information); R'R is
/// positive semidefinite and symmetric by construction, so nothing is lost over any number of updates, and
/// the solution equals the batch one to rounding. Two factors of separate rows merge into the factor of both.
///
/// Regressors and Outputs are fixed at compile time: update() allocates nothing and may run in a realtime
/// thread.
template <int kRegressors, int kOutputs>
class RecursiveLeastSquares {
 public:
  using Regressor = Eigen::Matrix<double, kRegressors, 1>;
  using Output = Eigen::Matrix<double, kOutputs, 1>;
  using Factor = Eigen::Matrix<double, kRegressors, kRegressors>;
  using Theta = Eigen::Matrix<double, kRegressors, kOutputs>;

  /// Adds one row: outputs f = Theta' phi + error.
  void update(const Regressor& phi, const Output& f) {
    rotate_in(phi, f);
    ++samples_;
  }

  /// Adds all rows of another factor, as if they had been seen here.
  void merge(const RecursiveLeastSquares& other) {
    for (int i = 0; i < kRegressors; ++i) {
      rotate_in(other.row(i), other.work_.template block<1, kOutputs>(i, kRegressors).transpose());
    }
    residual_ += other.residual_;
    samples_ += other.samples_;
  }

  [[nodiscard]] Factor R() const { return work_.template leftCols<kRegressors>(); }
  [[nodiscard]] Theta Z() const { return work_.template rightCols<kOutputs>(); }

  /// Sum of squared residuals per output of the least-squares solution of the rows so far.
  [[nodiscard]] const Output& residual() const { return residual_; }

  [[nodiscard]] Eigen::Index samples() const { return samples_; }

 private:
  static constexpr int kWidth = kRegressors + kOutputs;

  [[nodiscard]] Regressor row(int i) const { return work_.template block<1, kRegressors>(i, 0).transpose(); }

  void rotate_in(const Regressor& phi, const Output& f) {
    Eigen::Matrix<double, kWidth, 1> incoming;
    incoming << phi, f;
    for (int i = 0; i < kRegressors; ++i) {
      if (incoming[i] == 0.0) continue;
      const double radius = std::sqrt(work_(i, i) * work_(i, i) + incoming[i] * incoming[i]);
      if (radius == 0.0) continue;  // The square underflowed: nothing measurable is left in this element.
      const double c = work_(i, i) / radius;
      const double s = incoming[i] / radius;
      work_(i, i) = radius;
      for (int j = i + 1; j < kWidth; ++j) {
        const double kept = work_(i, j);
        work_(i, j) = c * kept + s * incoming[j];
        incoming[j] = c * incoming[j] - s * kept;
      }
    }
    residual_ += incoming.template tail<kOutputs>().cwiseAbs2();
  }

  Eigen::Matrix<double, kRegressors, kWidth, Eigen::RowMajor> work_ =
      Eigen::Matrix<double, kRegressors, kWidth, Eigen::RowMajor>::Zero();
  Output residual_ = Output::Zero();
  Eigen::Index samples_ = 0;
};

}  // namespace tonus::impedance
