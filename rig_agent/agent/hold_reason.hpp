#pragma once

#include <array>
#include <cstdint>

namespace tonus::rig {

/// Why a rig is held. A hold's line names one or more of them, with what belongs to it.
enum class HoldReason : std::uint8_t {
  kFault,                ///< "fault: workspace, speed": the loop's own limits.
  kLoopStandsStill,      ///< The driver does not return.
  kEndedUnderPower,      ///< The agent before this one.
  kLatchUnreadable,      ///< Whether the rig was held is not known.
  kWatchdogEnded,        ///< Nobody would drop the torque.
  kWatchdogStandsStill,  ///< Likewise.
  kSecondAgent,          ///< Another one of the same rig is on the bus.
};

inline constexpr std::array kHoldReasons{HoldReason::kFault,           HoldReason::kLoopStandsStill,
                                         HoldReason::kEndedUnderPower, HoldReason::kLatchUnreadable,
                                         HoldReason::kWatchdogEnded,   HoldReason::kWatchdogStandsStill,
                                         HoldReason::kSecondAgent};

/// As the manual has it: "loop_stands_still".
[[nodiscard]] const char* name_of(HoldReason reason);
/// What a hold's line contains for it: "the loop stands still: the driver does not return".
[[nodiscard]] const char* phrase_of(HoldReason reason);

}  // namespace tonus::rig
