#pragma once

#include <idl/session.h>

namespace tonus::cli {

/// "running", "waiting for the operator", ...
[[nodiscard]] inline const char* phase_name(v1::SessionPhase phase) {
  switch (phase) {
    case v1::SESSION_PREPARING:
      return "preparing";
    case v1::SESSION_READY:
      return "ready";
    case v1::SESSION_RUNNING:
      return "running";
    case v1::SESSION_PAUSING:
      return "pausing";
    case v1::SESSION_PAUSED:
      return "paused";
    case v1::SESSION_WAITING:
      return "waiting";
    case v1::SESSION_COMPLETING:
      return "completing";
    case v1::SESSION_COMPLETED:
      return "completed";
    case v1::SESSION_ABORTED:
      return "aborted";
    case v1::SESSION_FAILED:
      return "failed";
  }
  return "unknown";
}

}  // namespace tonus::cli
