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

}  // namespace tonus::v1
