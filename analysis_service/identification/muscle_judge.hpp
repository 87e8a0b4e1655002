#pragma once

#include "analysis_service/identification/trial_judge.hpp"
#include "analysis_service/muscles/trial_activity.hpp"

namespace tonus::identification {

/// Adds to a verdict what the muscles did, and whether the subject was relaxed before the onset. Keeps the
/// reference contractions of one session; trials are to come in the order of their verdicts, so that live
/// and offline judging know the same references. Not for use by several threads.
class MuscleJudge {
 public:
  /// For a session that begins: no reference is known.
  void begin(muscles::MuscleSettings settings);

  /// A valid contraction becomes a reference and has no activity of its own. Of any other trial with EMG and
  /// a rest before its onset: its activity, and Defect::kMusclesActive where a muscle is above the limit.
  void judge(const MeasuredTrial& trial, const JudgeLimits& limits, Verdict& verdict);

  /// An operator rejected this contraction: the trials that are judged from now on do not refer to it. Those
  /// that were judged before keep their verdicts, as they were told.
  void withdraw(const Id& trial) { reference_.withdraw(trial); }

  [[nodiscard]] const muscles::Reference& reference() const { return reference_; }

 private:
  muscles::MuscleSettings settings_;
  muscles::Reference reference_;
};

}  // namespace tonus::identification
