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
  Eigen::VectorXd unknowns;              ///< P, Q, G, each column by column (SI, G 1), and the delay d, s.
  bool is_found = false;
};

/// Motion of (3) for a command of 1 m along one axis, rows x axes.
struct AxisMotion {
  Eigen::MatrixXd x;  ///< m.
  Eigen::MatrixXd v;  ///< m/s.
  Eigen::MatrixXd a;  ///< m/s2.
};

/// Fits (3), P x" + Q x' + x = G xc(t - d), to the mean response by output error: Levenberg-Marquardt over
/// the elements of P, Q, G and the delay d, from a weak-form start and, where that fails, from three damped
/// oscillators. Between rows the command is a straight line. Where (3) holds only roughly, the instrument
/// stays independent of the disturbance; the estimate then loses precision, not consistency.
[[nodiscard]] CommandResponse command_response(const MeanResponse& measured);

/// The fitted response, by axis, to a command of this shape at this sample period (s). `fitted` was found.
[[nodiscard]] std::vector<AxisMotion> motion_of(const CommandResponse& fitted, Eigen::Index axes,
                                                const Eigen::VectorXd& shape, double sample_period);

}  // namespace tonus::refined
