#include "analysis_service/refined/whitener.hpp"

#include <Eigen/Dense>

namespace tonus::refined {
namespace {

Eigen::MatrixXd inverse_cholesky(const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd L = covariance.llt().matrixL();
  return L.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(L.rows(), L.cols()));
}

}  // namespace

Whitener::Whitener(Eigen::Index n, Eigen::Index axes)
    : n_(n), axes_(axes), filter_{Eigen::MatrixXd::Identity(axes, axes)} {}

Whitener::Whitener(const ResidualProcess& process, Eigen::Index n, const Eigen::MatrixXd& offset_scatter)
    : n_(n), axes_(process.S.rows()) {
  filter_.push_back(inverse_cholesky(process.S));
  for (const Eigen::MatrixXd& A : process.A) filter_.emplace_back(-filter_.front() * A);
  if (process.order() > 0) {
    // The state holds the newest sample first; the start is ordered by time.
    const Eigen::Index order = process.order();
    Eigen::MatrixXd by_time(order * axes_, order * axes_);
    for (Eigen::Index i = 0; i < order; ++i) {
      for (Eigen::Index j = 0; j < order; ++j)
        by_time.block(i * axes_, j * axes_, axes_, axes_) =
            process.state.block((order - 1 - i) * axes_, (order - 1 - j) * axes_, axes_, axes_);
    }
    start_ = inverse_cholesky(by_time);
  }
  if (!(offset_scatter.trace() > 0.0)) return;
  const Eigen::MatrixXd ones = design(Eigen::MatrixXd::Ones(n, 1));
  const Eigen::HouseholderQR<Eigen::MatrixXd> factor(ones);
  const Eigen::MatrixXd R = factor.matrixQR().topRows(axes_).triangularView<Eigen::Upper>();
  const Eigen::MatrixXd inflated =
      Eigen::MatrixXd::Identity(axes_, axes_) + R * offset_scatter * R.transpose();
  shrink_ = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(inflated).operatorInverseSqrt() -
            Eigen::MatrixXd::Identity(axes_, axes_);
  offset_ = factor.householderQ() * Eigen::MatrixXd::Identity(ones.rows(), axes_);
}

Eigen::VectorXd Whitener::signal(const Eigen::MatrixXd& y) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(axes_ * n_, 1);
  for (Eigen::Index axis = 0; axis < axes_; ++axis) add_axis(axis, y.col(axis), out);
  shrink_offset(out);
  return out;
}

Eigen::MatrixXd Whitener::design(const Eigen::MatrixXd& regressors) const {
  const Eigen::Index q = regressors.cols();
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(axes_ * n_, axes_ * q);
  for (Eigen::Index axis = 0; axis < axes_; ++axis) add_axis(axis, regressors, out.middleCols(axis * q, q));
  shrink_offset(out);
  return out;
}

void Whitener::add_axis(Eigen::Index axis, const Eigen::MatrixXd& values,
                        Eigen::Ref<Eigen::MatrixXd> out) const {
  const auto order = static_cast<Eigen::Index>(filter_.size()) - 1;
  for (Eigen::Index row = 0; row < axes_; ++row) {
    for (Eigen::Index lag = 0; lag <= order; ++lag) {
      const double weight = filter_[static_cast<std::size_t>(lag)](row, axis);
      if (weight == 0.0) continue;
      out.middleRows(row * n_ + order, n_ - order) += weight * values.middleRows(order - lag, n_ - order);
    }
    for (Eigen::Index i = 0; i < order; ++i) {
      for (Eigen::Index j = 0; j <= i; ++j)
        out.row(row * n_ + i) += start_(i * axes_ + row, j * axes_ + axis) * values.row(j);
    }
  }
}

void Whitener::shrink_offset(Eigen::MatrixXd& values) const {
  if (offset_.size() == 0) return;
  values.noalias() += offset_ * (shrink_ * (offset_.transpose() * values)).eval();
}

}  // namespace tonus::refined
