#pragma once

#include "services/doctor/facts.hpp"
#include "services/runtime/options.hpp"

namespace tonus::doctor {

/// What this host tells without the bus: clock, realtime, interface, firewall, peers, disk, permissions,
/// certificates. Writes and removes one small file in the data folder.
void find_host_facts(const runtime::CommonOptions& options, Facts& facts);

}  // namespace tonus::doctor
