#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis_service/refined/residual_process.hpp"

namespace tonus::refined {

/// Multiplies a trial by the inverse root of its covariance (6), (7): T + S_c (x) 11', T the exact covariance
/// of n samples of the residual process and S_c the trials' own scatter of offsets.
///
/// T^-1/2 is banded: the innovations of the process, and for its first `order` samples the inverse Cholesky
/// factor of their covariance. S_c is of rank axes in the whitened space, so that it costs one small root.
/// Rows of what comes out: n of the first axis, then n of the second.
class Whitener {
 public:
  /// Leaves everything as it is.
  Whitener(Eigen::Index n, Eigen::Index axes);
  /// `offset_scatter`: S_c, N2, axes x axes, positive semidefinite.
  Whitener(const ResidualProcess& process, Eigen::Index n, const Eigen::MatrixXd& offset_scatter);

  /// A trial's force, n x axes.
  [[nodiscard]] Eigen::VectorXd signal(const Eigen::MatrixXd& y) const;
  /// A trial's regressors (n x q), which act on each axis with coefficients of its own: (axes n) x (axes q),
  /// the columns of the first axis first.
  [[nodiscard]] Eigen::MatrixXd design(const Eigen::MatrixXd& regressors) const;

 private:
  void add_axis(Eigen::Index axis, const Eigen::MatrixXd& values, Eigen::Ref<Eigen::MatrixXd> out) const;
  void shrink_offset(Eigen::MatrixXd& values) const;

  Eigen::Index n_ = 0;
  Eigen::Index axes_ = 0;
  std::vector<Eigen::MatrixXd> filter_;  // by lag from 0: innovation, whitened
  Eigen::MatrixXd start_;                // of the first samples, ordered (time, axis)
  Eigen::MatrixXd offset_;               // (axes n) x axes, orthonormal; empty: no scatter
  Eigen::MatrixXd shrink_;               // what is added to each offset's share
};

}  // namespace tonus::refined
