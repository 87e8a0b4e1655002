#include "rig_agent/agent/hold_reason.hpp"

namespace tonus::rig {

const char* name_of(HoldReason reason) {
  switch (reason) {
    case HoldReason::kFault:
      return "fault";
    case HoldReason::kLoopStandsStill:
      return "loop_stands_still";
    case HoldReason::kEndedUnderPower:
      return "ended_under_power";
    case HoldReason::kLatchUnreadable:
      return "latch_unreadable";
    case HoldReason::kWatchdogEnded:
      return "watchdog_ended";
    case HoldReason::kWatchdogStandsStill:
      return "watchdog_stands_still";
    case HoldReason::kSecondAgent:
      return "second_agent";
  }
  return "unknown";
}

const char* phrase_of(HoldReason reason) {
  switch (reason) {
    case HoldReason::kFault:
      return "fault: ";
    case HoldReason::kLoopStandsStill:
      return "the loop stands still: the driver does not return";
    case HoldReason::kEndedUnderPower:
      return "the rig agent ended while the rig was under power";
    case HoldReason::kLatchUnreadable:
      return "whether the rig was held is not known";
    case HoldReason::kWatchdogEnded:
      return "the watchdog has ended";
    case HoldReason::kWatchdogStandsStill:
      return "the watchdog stands still";
    case HoldReason::kSecondAgent:
      return "a second agent of this rig";
  }
  return "unknown";
}

}  // namespace tonus::rig
