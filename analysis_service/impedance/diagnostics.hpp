#pragma once

#include <optional>
#include <span>

#include "analysis_service/impedance/axes.hpp"
#include "analysis_service/impedance/cross_check.hpp"
#include "analysis_service/impedance/options.hpp"
#include "analysis_service/impedance/trial.hpp"

namespace tonus::impedance {

/// Defects of a condition's data that no fit can mend, found without regard to the method.
struct Diagnosis {
  bool is_single_direction = false;
  bool is_force_collinear = false;
  bool is_force_clipped = false;
  bool is_force_shifted = false;
  bool is_lag_examined = false;
  double misfit = 0.0;  ///< Largest of the channels' (force_lag.hpp), as is the next.
  double misfit_share = 0.0;
  std::optional<CrossCheck> cross_check;  ///< Of two methods; set by identify().
  /// Tests against model (3), which replace that of the shift and, with commands, that of the misfit. Set by
  /// take_tests().
  const refined::Estimate* model_tests = nullptr;
  bool is_by_mean_motion = false;
  AxisVector force_lag;  ///< s by which each force channel lags; positive: too late. 0 where not examined.
};

/// Limits of the diagnosis; each stands well apart from what sound data give (tests/unit/impedance).
inline constexpr double kDirectionSpread =
    0.10;  ///< Minor over major axis of the displacements: less is one line.
inline constexpr double kForceSpread = 0.03;    ///< Minor over major axis of the force: less is one signal.
inline constexpr double kFlatDuration = 0.025;  ///< s that a channel stands at its extreme: clipped.

/// Examines the trials of one condition; all have the same axes and sample period, and step trials last for
/// `options.window` s from the onset.
///
/// Direction: axes ratio of the trials' mean commanded displacements (measured ones where the command is not
/// known, or zero throughout); of the whole scatter in continuous records.
/// Collinear force and shifted force are judged on the condition's mean response (condition_response.hpp),
/// which averages sensor noise and voluntary force over trials, behind a filter (8) of twice the motion's
/// `frequency` (Hz, as tuned) and damping ratio 0.7; the shift by force_lag.hpp. Continuous records are not
/// examined for it (reflexes delay their force). Clipped: a trial marked so, or a channel that stands still
/// at its extreme.
[[nodiscard]] Diagnosis diagnose(std::span<const Trial* const> trials, const Options& options,
                                 double frequency);

/// The trials were tested against model (3). `tests` outlives the diagnosis; `is_by_mean_motion`: they are
/// those of tests_by_mean_motion().
void take_tests(const refined::Estimate& tests, bool is_by_mean_motion, Diagnosis& diagnosis);

}  // namespace tonus::impedance
