#include "services/runtime/service_manager.hpp"

#include <systemd/sd-daemon.h>

#include "services/core/text.hpp"

namespace tonus::runtime {

// shown() leaves no line end: a state cannot bring in assignments of its own.
void tell_service_manager(const std::string& state) {
  (void)sd_notify(0, ("READY=1\nWATCHDOG=1\nSTATUS=" + shown(state)).c_str());
}

void tell_service_manager_of_the_end() { (void)sd_notify(0, "STOPPING=1"); }

}  // namespace tonus::runtime
