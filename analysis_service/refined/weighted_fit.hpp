#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis_service/refined/residual_process.hpp"
#include "analysis_service/refined/whitener.hpp"

namespace tonus::refined {

/// A trial in the weak form: n test functions, q = 3 axes + 1 regressors [x" x' x 1].
struct TrialRows {
  Eigen::MatrixXd force;        ///< N, n x axes.
  Eigen::MatrixXd regressors;   ///< Of the measured motion, n x q.
  Eigen::MatrixXd instruments;  ///< Of the motion that the command predicts, n x q.
};

/// (5) to (7) at their end.
struct WeightedFit {
  bool is_found = false;    ///< The instruments determine the parameters.
  Eigen::MatrixXd theta;    ///< q x axes, F = theta' [x" x' x 1].
  ResidualProcess process;  ///< Of the residuals.
  Eigen::MatrixXd offset_scatter;
  std::vector<Eigen::MatrixXd> residuals;  ///< N, of each trial, n x axes.
  // Whitened:
  std::vector<Eigen::VectorXd> y;
  std::vector<Eigen::MatrixXd> X;
  std::vector<Eigen::MatrixXd> Z;
  Eigen::MatrixXd ZX;      ///< sum Z'X
  double condition = 0.0;  ///< Of sum Z'Z with its columns scaled to unit length.
  Whitener whitener{0, 1};
};

/// Repeats (6) and the weighting (5), (7), from unweighted instruments on. At least two trials.
[[nodiscard]] WeightedFit fit_weighted(const std::vector<TrialRows>& trials);

}  // namespace tonus::refined
