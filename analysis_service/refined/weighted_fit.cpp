#include "analysis_service/refined/weighted_fit.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace tonus::refined {
namespace {

constexpr int kRounds = 4;

/// (6) with the whitener that is there.
void solve(const std::vector<TrialRows>& trials, WeightedFit& fit) {
  const Eigen::Index axes = trials.front().force.cols();
  const Eigen::Index q = trials.front().regressors.cols();
  const Eigen::Index size = axes * q;
  fit.y.clear();
  fit.X.clear();
  fit.Z.clear();
  fit.ZX = Eigen::MatrixXd::Zero(size, size);
  Eigen::MatrixXd ZZ = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd Zy = Eigen::VectorXd::Zero(size);
  for (const TrialRows& trial : trials) {
    fit.y.push_back(fit.whitener.signal(trial.force));
    fit.X.push_back(fit.whitener.design(trial.regressors));
    fit.Z.push_back(fit.whitener.design(trial.instruments));
    const Eigen::MatrixXd& Z = fit.Z.back();
    fit.ZX.noalias() += Z.transpose() * fit.X.back();
    ZZ.noalias() += Z.transpose() * Z;
    Zy.noalias() += Z.transpose() * fit.y.back();
  }
  const Eigen::VectorXd scale = ZZ.diagonal().cwiseSqrt().cwiseInverse();
  fit.is_found = scale.allFinite();
  if (!fit.is_found) return;
  const Eigen::MatrixXd scaled = scale.asDiagonal() * ZZ * scale.asDiagonal();
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled).eigenvalues();
  fit.condition = std::sqrt(values[size - 1] / std::max(values[0], 0.0));
  const Eigen::MatrixXd G = scale.asDiagonal() * fit.ZX * scale.asDiagonal();
  const Eigen::VectorXd solution = scale.cwiseProduct(G.partialPivLu().solve(scale.cwiseProduct(Zy)));
  fit.theta = solution.reshaped(q, axes);
  fit.is_found = fit.theta.allFinite() && std::isfinite(fit.condition);
  fit.residuals.clear();
  for (const TrialRows& trial : trials)
    fit.residuals.emplace_back(trial.force - trial.regressors * fit.theta);
}

std::vector<Eigen::MatrixXd> about_their_mean(std::vector<Eigen::MatrixXd> residuals) {
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(residuals.front().cols());
  for (const Eigen::MatrixXd& e : residuals) mean += e.colwise().mean();
  mean /= static_cast<double>(residuals.size());
  for (Eigen::MatrixXd& e : residuals) e.rowwise() -= mean;
  return residuals;
}

/// S_c of (7): how much more the trials' means scatter than the process says, where they do.
Eigen::MatrixXd offset_scatter(const std::vector<Eigen::MatrixXd>& residuals,
                               const ResidualProcess& process) {
  const Eigen::Index axes = process.S.rows();
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(axes, axes);
  for (const Eigen::MatrixXd& e : residuals) {
    const Eigen::RowVectorXd mean = e.colwise().mean();
    scatter += mean.transpose() * mean;
  }
  scatter /= static_cast<double>(residuals.size() - 1);
  scatter -= covariance_of_mean(process, residuals.front().rows());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(scatter);
  return modes.eigenvectors() * modes.eigenvalues().cwiseMax(0.0).asDiagonal() *
         modes.eigenvectors().transpose();
}

}  // namespace

WeightedFit fit_weighted(const std::vector<TrialRows>& trials) {
  const Eigen::Index n = trials.front().force.rows();
  WeightedFit fit;
  fit.whitener = Whitener(n, trials.front().force.cols());
  Eigen::Index order = 0;
  for (int round = 0;; ++round) {
    solve(trials, fit);
    if (!fit.is_found || round == kRounds - 1) return fit;
    const auto residuals = about_their_mean(fit.residuals);
    if (round < 2) order = chosen_order(residuals);
    fit.process = fit_process(residuals, order);
    fit.offset_scatter = offset_scatter(residuals, fit.process);
    fit.whitener = Whitener(fit.process, n, fit.offset_scatter);
  }
}

}  // namespace tonus::refined
