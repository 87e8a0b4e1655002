#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>

namespace tonus::impedance {

/// Recursive least squares in square-root information form. For rows (phi, f) seen so far, with Phi, F
/// stacked:
///
///     Q [Phi F] = [R Z; 0 E],   R upper triangular, R Theta = Z,   ||F - Phi Theta||^2 = ||E||^2 per output,
///
/// and rows, one or several at once, are reflected into [R Z] by Householder's H = I - 2 v v' / v'v, column
/// after column. It starts at R = 0 (no prior information); R'R is positive semidefinite and symmetric by
/// construction, so nothing is lost over any number of updates, and the solution equals the batch one to
/// rounding. Two factors of separate rows merge into the factor of both.
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

  static constexpr int kWidth = kRegressors + kOutputs;
  static constexpr int kBlockRows = 16;
  /// Rows [phi' f'] of a block.
  using Block = Eigen::Matrix<double, kBlockRows, kWidth>;

  /// Adds one row: outputs f = Theta' phi + error.
  void update(const Regressor& phi, const Output& f) {
    Eigen::Matrix<double, 1, kWidth> row;
    row << phi.transpose(), f.transpose();
    reflect_in(row);
    ++samples_;
  }

  /// Adds the first `rows` rows of a block; the others must be zero. Several times as fast as row by row.
  void update(Block block, Eigen::Index rows) {
    reflect_in(block);
    samples_ += rows;
  }

  /// Adds all rows of another factor, as if they had been seen here.
  void merge(const RecursiveLeastSquares& other) {
    Eigen::Matrix<double, kRegressors, kWidth> rows = other.work_;
    reflect_in(rows);
    residual_ += other.residual_;
    samples_ += other.samples_;
  }

  [[nodiscard]] Factor R() const { return work_.template leftCols<kRegressors>(); }
  [[nodiscard]] Theta Z() const { return work_.template rightCols<kOutputs>(); }

  /// Sum of squared residuals per output of the least-squares solution of the rows so far.
  [[nodiscard]] const Output& residual() const { return residual_; }

  [[nodiscard]] Eigen::Index samples() const { return samples_; }

 private:
  /// Reflects column after column of the rows onto R's diagonal, which stays positive: H = I - 2 v v' / v'v
  /// with v = [R_ii - r; b], b the column, r = sqrt(R_ii^2 + b'b), and R_ii - r = -b'b / (R_ii + r) without
  /// cancellation.
  template <int kRows>
  void reflect_in(Eigen::Matrix<double, kRows, kWidth>& rows) {
    for (int i = 0; i < kRegressors; ++i) {
      const double squares = rows.col(i).squaredNorm();
      if (squares < kNegligible) continue;
      const double radius = std::sqrt(work_(i, i) * work_(i, i) + squares);
      const double v = -squares / (work_(i, i) + radius);
      const double scale = -1.0 / (radius * v);  // 2 / v'v
      work_(i, i) = radius;
      for (int j = i + 1; j < kWidth; ++j) {
        const double part = scale * (v * work_(i, j) + rows.col(i).dot(rows.col(j)));
        work_(i, j) -= part * v;
        rows.col(j) -= part * rows.col(i);
      }
    }
    residual_ += rows.template rightCols<kOutputs>().colwise().squaredNorm().transpose();
  }

  /// N^2 and so on: below it a square has lost digits, and nothing measurable is left.
  static constexpr double kNegligible =
      std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon();

  Eigen::Matrix<double, kRegressors, kWidth, Eigen::RowMajor> work_ =
      Eigen::Matrix<double, kRegressors, kWidth, Eigen::RowMajor>::Zero();
  Output residual_ = Output::Zero();
  Eigen::Index samples_ = 0;
};

}  // namespace tonus::impedance
