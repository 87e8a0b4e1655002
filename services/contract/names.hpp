#pragma once

#include <idl/estimate.h>
#include <idl/rig.h>
#include <idl/session.h>
#include <idl/trial.h>

/// Names of the contract's enumerations, for people; and what groups of their values mean. A value of a newer
/// contract is "unknown".
namespace tonus::v1 {

/// "preparing", "ready", "running", ...
[[nodiscard]] const char* phase_name(SessionPhase phase);

/// True where nothing more will come of a session in this phase: completed, aborted or failed.
[[nodiscard]] bool is_over(SessionPhase phase);

/// "starting", "free", "armed", "in trial", "held"
[[nodiscard]] const char* mode_name(RigMode mode);

/// "completed", "aborted", "faulted", ...
[[nodiscard]] const char* end_name(TrialEnd end);

/// Why a trial is not valid: "off target", "bias not held", ...
[[nodiscard]] const char* reason_name(VerdictReason reason);

/// "ok", "undetermined" or "suspect".
[[nodiscard]] const char* status_name(EstimateStatus status);

/// "explained_share", "coherence", "halves", ... as files have them.
[[nodiscard]] const char* test_name(FitTest test);

}  // namespace tonus::v1
