#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "analysis_service/refined/alternatives.hpp"
#include "analysis_service/refined/command_response.hpp"
#include "analysis_service/refined/trial_covariance.hpp"

namespace tonus::refined {

/// One perturbation. All trials of a condition have the same axes (1 or 2) and sample period.
struct Trial {
  Eigen::MatrixXd displacement;  ///< m, from the mean of the rest, rows x axes.
  Eigen::MatrixXd force;         ///< N, of the handle on the arm, rows x axes.
  Eigen::MatrixXd commanded;     ///< m, commanded displacement, rows x axes.
  Eigen::Index onset = 0;        ///< First row of the perturbation.
  /// What was taken away as the rest's mean (axes); empty: nothing. A tare from each trial's own rest adds
  /// that rest's noise to the trial; M, B, K are fitted without it.
  Eigen::VectorXd displacement_taken{};
  Eigen::VectorXd force_taken{};
};

struct Settings {
  double sample_period = 0.0;  ///< s.
  double window = 1.0;         ///< s from the onset.
  double handle_mass = 0.0;    ///< kg between sensor and hand; taken from M.
};

/// Why there are no numbers.
enum class Shortage : std::uint8_t {
  kNone,
  kTooFewTrials,     ///< Fewer than kFewestTrials.
  kTooFewRows,       ///< Too short for the test functions.
  kNoCommand,        ///< A trial's commanded displacement is not known, or never moves.
  kSingleDirection,  ///< The commands act along one line.
  kNoResponse,       ///< (3) could not be fitted to the mean response.
  kSingular,         ///< The instruments do not determine the parameters.
};

inline constexpr std::size_t kFewestTrials = 4;

/// The motion that the command alone makes, over the rows that all trials have around their onsets, at the
/// rate of the samples: in trial j, targets(j, b) of of_axis[b], summed.
struct CommandMotion {
  Eigen::Index rest = 0;    ///< Rows before the onset.
  Eigen::MatrixXd targets;  ///< m, trials x axes.
  std::vector<AxisMotion> of_axis;
};

/// M, B, K of F = M x" + B x' + K (x - X0), with what an interval needs. Empty while there is a shortage.
struct Estimate {
  Shortage shortage = Shortage::kTooFewTrials;
  Eigen::MatrixXd theta;                      ///< (3 axes + 1) x axes, F = theta' [x" x' x 1].
  std::optional<TrialCovariance> covariance;  ///< Of vec(theta).
  Eigen::VectorXd X0;                         ///< m, from the rest's mean position, mean over trials.
  Eigen::VectorXd X0_std;                     ///< m, of that mean.
  Eigen::MatrixXd X0_covariance;              ///< m2.
  double X0_freedom = 0.0;
  Eigen::VectorXd sigma;             ///< N, root mean square of the residual behind the test functions, axes.
  double condition = 0.0;            ///< Of the whitened instruments, columns of unit length.
  Eigen::Index rows = 0;             ///< Samples behind it, all trials.
  Eigen::Index order = 0;            ///< Of the residual process.
  double command_unexplained = 1.0;  ///< Share of the mean response's squares that (3) leaves.
  double white = 0.0;                ///< Largest correlation of neighbouring whitened residuals, by axis.
  std::vector<AlternativeTest> alternatives;
  LagTest lag;
  MisfitTest misfit;
  CommandMotion motion;
  ResidualProcess process;         ///< At test functions 20 ms apart.
  Eigen::MatrixXd offset_scatter;  ///< N2.
};

/// Identifies a condition by instrumental variables (README.md). The result depends on the trials and their
/// order alone: a live estimate after a trial is this function on the trials so far. Pure, thread-safe,
/// allocates.
[[nodiscard]] Estimate identify(const std::vector<Trial>& trials, const Settings& settings);

}  // namespace tonus::refined
