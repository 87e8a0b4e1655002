#include "services/contract/names.hpp"

namespace tonus::v1 {

const char* phase_name(SessionPhase phase) {
  switch (phase) {
    case SESSION_PREPARING:
      return "preparing";
    case SESSION_READY:
      return "ready";
    case SESSION_RUNNING:
      return "running";
    case SESSION_PAUSING:
      return "pausing";
    case SESSION_PAUSED:
      return "paused";
    case SESSION_WAITING:
      return "waiting";
    case SESSION_COMPLETING:
      return "completing";
    case SESSION_COMPLETED:
      return "completed";
    case SESSION_ABORTED:
      return "aborted";
    case SESSION_FAILED:
      return "failed";
  }
  return "unknown";
}

bool is_over(SessionPhase phase) {
  return phase == SESSION_COMPLETED || phase == SESSION_ABORTED || phase == SESSION_FAILED;
}

const char* mode_name(RigMode mode) {
  switch (mode) {
    case RIG_STARTING:
      return "starting";
    case RIG_FREE:
      return "free";
    case RIG_ARMED:
      return "armed";
    case RIG_IN_TRIAL:
      return "in trial";
    case RIG_HELD:
      return "held";
  }
  return "unknown";
}

const char* end_name(TrialEnd end) {
  switch (end) {
    case TRIAL_COMPLETED:
      return "completed";
    case TRIAL_ABORTED:
      return "aborted";
    case TRIAL_FAULTED:
      return "faulted";
    case TRIAL_NOT_CENTRED:
      return "not centred";
    case TRIAL_BIAS_NOT_REACHED:
      return "bias not reached";
    case TRIAL_REFUSED:
      return "refused";
    case TRIAL_BROKEN_OFF:
      return "broken off";
  }
  return "unknown end";
}

const char* reason_name(VerdictReason reason) {
  switch (reason) {
    case REASON_NOT_COMPLETED:
      return "not completed";
    case REASON_OFF_TARGET:
      return "off target";
    case REASON_BIAS_NOT_REACHED:
      return "bias not reached";
    case REASON_BIAS_NOT_HELD:
      return "bias not held";
    case REASON_EARLY_REACTION:
      return "early reaction";
    case REASON_SATURATED:
      return "saturated";
    case REASON_GAP:
      return "gap";
    case REASON_EXCURSION:
      return "excursion";
    case REASON_NOT_AT_REST:
      return "not at rest";
    case REASON_UNKNOWN_RIG:
      return "unknown rig";
    case REASON_LET_GO:
      return "let go";
    case REASON_MUSCLES_ACTIVE:
      return "muscles active";
    case REASON_REJECTED_BY_HAND:
      return "rejected by hand";
  }
  return "unknown reason";
}

const char* status_name(EstimateStatus status) {
  switch (status) {
    case ESTIMATE_OK:
      return "ok";
    case ESTIMATE_UNDETERMINED:
      return "undetermined";
    case ESTIMATE_SUSPECT:
      return "suspect";
  }
  return "unknown";
}

const char* test_name(FitTest test) {
  switch (test) {
    case FIT_EXPLAINED_SHARE:
      return "explained_share";
    case FIT_COHERENCE:
      return "coherence";
    case FIT_HALVES:
      return "halves";
    case FIT_STEADINESS:
      return "steadiness";
    case FIT_BANDS:
      return "bands";
    case FIT_REFLEX:
      return "reflex";
    case FIT_LAG:
      return "lag";
    case FIT_UNITS:
      return "units";
    case FIT_FRICTION:
      return "friction";
    case FIT_HARDENING:
      return "hardening";
    case FIT_POSITION:
      return "position";
    case FIT_CLIPPING:
      return "clipping";
    case FIT_HELD_SAMPLES:
      return "held_samples";
    case FIT_CROSS_CHECK:
      return "cross_check";
    case FIT_WIDTH:
      return "width";
  }
  return "unknown";
}

}  // namespace tonus::v1
