#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "analysis_service/spectral/motion_estimate.hpp"

namespace tonus::spectral {

/// Normal equations of the residual of one force axis on X2, X1, X0 of x^, on the lag, and on further terms,
/// by block of segments (equation 13). Columns: 3 N of motion, 1 of the lag, then the terms. Scaled.
class TermRegression {
 public:
  struct Solution {
    Eigen::VectorXd theta;          ///< Of the chosen columns.
    Eigen::MatrixXd without_block;  ///< The same without one block each, a column a block.
    double reduction = 0.0;  ///< Of the weighted sum of squares, from that of the columns of motion and lag.
    double explained = 0.0;  ///< Weighted squares that the columns explain,
    Eigen::VectorXd explained_without_block;  ///< and those without one block each.
  };

  /// `motion`: windowed spectra of x^, by segment, rows F, X2, X1, X0, columns from bin `first_bin` on.
  /// `terms`: by segment, a row a term, a column a fitted bin. `removed`, one a term: how much of each the
  /// force lost before the fit.
  template <int N>
  static TermRegression make(const SegmentFit<N>& fit, int force_axis,
                             std::span<const Eigen::MatrixXcd> motion, Eigen::Index first_bin,
                             std::span<const Eigen::MatrixXcd> terms, const Eigen::VectorXd& removed);

  /// With the columns of motion, the lag and these terms.
  [[nodiscard]] Solution solve(std::span<const int> terms) const;
  /// The columns of motion and the lag alone.
  [[nodiscard]] const Eigen::VectorXd& plain() const { return plain_; }
  /// Share of the force's root mean square that a term of this coefficient carries.
  [[nodiscard]] double share(int term, double coefficient) const;
  [[nodiscard]] int linear_columns() const { return linear_; }

  /// Standard errors of a solution by the jackknife over blocks.
  [[nodiscard]] static Eigen::VectorXd standard_errors(const Eigen::MatrixXd& without_block);

 private:
  struct Normal {
    Eigen::MatrixXd A;
    Eigen::VectorXd b;
  };

  int linear_ = 0;
  std::vector<Normal> blocks_;
  Normal all_;
  Eigen::VectorXd plain_;
  double force_power_ = 0.0;
};

}  // namespace tonus::spectral
