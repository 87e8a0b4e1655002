#pragma once

#include <Eigen/Core>
#include <vector>

namespace tonus::refined {

/// What a condition's trials have in common: their mean response to the command.
struct MeanResponse {
  double sample_period = 0.0;  ///< s.
  Eigen::Index rest = 0;       ///< Rows before the command begins to move.
  Eigen::VectorXd shape;       ///< s(t), rows: the command as a share of its largest value.
  /// R(t) of (4): of a command of 1 m along each axis, the displacement, rows x axes, m.
  std::vector<Eigen::MatrixXd> of_axis;
};

/// The motion that the command alone predicts, and how well.
struct CommandResponse {
  std::vector<Eigen::MatrixXd> of_axis;  ///< As in MeanResponse.
  double unexplained = 1.0;              ///< Share of the mean response's squares that (3) leaves.
  bool is_found = false;
};

/// Fits (3), P x" + Q x' + x = G xc(t - d), to the mean response by output error: Levenberg-Marquardt over
/// the elements of P, Q, G and the delay d, from a weak-form start and, where that fails, from three damped
/// oscillators. Between rows the command is a straight line. Where (3) holds only roughly, the instrument
/// stays independent of the disturbance; the estimate then loses precision, not consistency.
[[nodiscard]] CommandResponse command_response(const MeanResponse& measured);

}  // namespace tonus::refined
