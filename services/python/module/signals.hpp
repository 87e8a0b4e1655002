#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "services/core/result.hpp"
#include "services/recording/recording.hpp"
#include "services/store/archived_trial.hpp"

/// Measured rows as whole columns. No Python.
namespace tonus::python {

/// Rows of one recording, or of several trials one after the other. Pairs are row-major, rows x axes.
struct Signals {
  unsigned axes = 2;
  std::vector<double> time;       ///< s; of a trial from the onset, of a recording from its first row.
  std::vector<double> position;   ///< m in S, endpoint from the shoulder; one-axis rigs: their displacement.
  std::vector<double> force;      ///< N in S, of the handle on the arm; one-axis rigs: in their unit.
  std::vector<double> commanded;  ///< m in S, displacement commanded from the posture.
  std::vector<std::uint8_t> phase;       ///< v1::TrialPhase; of a recording without phases: all idle.
  std::vector<std::uint8_t> is_missing;  ///< 1: nothing was measured, the row's numbers are NaN.

  [[nodiscard]] std::size_t rows() const { return time.size(); }
};

/// Columns of a recording, converted by its own rig.
[[nodiscard]] Signals signals_of(const recording::Recording& record);

/// An archived trial's place in Signals.
struct TrialRows {
  std::uint32_t attempt = 0;
  std::size_t first = 0;
  std::size_t rows = 0;
  std::int64_t onset = -1;  ///< Row from `first`; -1: it has none.
};

struct SessionSignals {
  Signals signals;
  std::vector<TrialRows> trials;
};

/// Rows of trials of one session, in their order, through the one way from an archive (read_trial_samples,
/// rig_in_force, convert). A trial without samples has no rows. Errors: those of
/// reading; kInvalidArgument: trials of rigs with different axes.
[[nodiscard]] Result<SessionSignals> read_signals(store::Store& store, const store::Session& session,
                                                  const std::vector<const store::SessionTrial*>& trials);

/// What a trial's auxiliary channels gave, and the time of each channel's first value from the onset, s.
struct TrialAuxiliary {
  std::vector<AuxiliarySeries> series;
  double first_sample_time = 0.0;  ///< Of the trial's first sample, from the onset.
};

/// As store::read_trial_auxiliary(); nothing of a trial without samples.
[[nodiscard]] Result<TrialAuxiliary> read_auxiliary(store::Store& store, const store::Session& session,
                                                    const store::SessionTrial& trial);

}  // namespace tonus::python
