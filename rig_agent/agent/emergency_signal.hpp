#pragma once

#include "rig_agent/control/rig_loop.hpp"

namespace tonus::rig {

/// Makes SIGUSR1 an emergency stop of the loop: the handler sets the loop's flag, which the next cycle acts
/// upon, whatever the rest of the program is doing. Before construction and after destruction the signal has
/// its default action, which ends the program. At most one in a process.
class EmergencySignal {
 public:
  explicit EmergencySignal(control::RigLoop& loop);
  ~EmergencySignal();
  EmergencySignal(const EmergencySignal&) = delete;
  EmergencySignal& operator=(const EmergencySignal&) = delete;
};

}  // namespace tonus::rig
