#pragma once

#include <string>

namespace tonus::runtime {

/// What systemd is told of a service with Type=notify: that it runs (READY=1), that it still does
/// (WATCHDOG=1, at least every half second, for WatchdogSec=), and what `systemctl status` shows. Nothing
/// where no service manager asked for it (NOTIFY_SOCKET).
void tell_service_manager(const std::string& state);

/// That it ends now.
void tell_service_manager_of_the_end();

}  // namespace tonus::runtime
