#pragma once

#include <string>

#include "services/bus/bus.hpp"

namespace tonus::bench {

/// Of a participant on this machine. `dds` is "fastdds" or "cyclonedds", as the command line has checked.
inline bus::BusOptions bus_options(const std::string& dds, int domain, const std::string& name) {
  bus::BusOptions options;
  options.vendor = *bus::parse_vendor(dds);
  options.domain = domain;
  options.participant_name = name;
  return options;
}

}  // namespace tonus::bench
