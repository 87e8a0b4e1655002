#include "rig_agent/control/fault_text.hpp"

namespace tonus::control {

std::string fault_text(FaultBits faults) {
  std::string text;
  for (const auto fault : kAllFaults) {
    if ((faults & bit(fault)) == 0) continue;
    text += (text.empty() ? "" : ", ") + std::string(fault_name(fault));
  }
  return text;
}

}  // namespace tonus::control
