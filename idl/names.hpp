#pragma once

#include <idl/session.h>

/// Names of the contract's enumerations, for people.
namespace tonus::v1 {

/// "preparing", "ready", "running", ...
[[nodiscard]] inline const char* phase_name(SessionPhase phase) {
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

}  // namespace tonus::v1
