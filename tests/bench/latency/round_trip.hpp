#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "services/bus/bus.hpp"

namespace tonus::bench {

/// Sizes and rate of a bare round trip's messages.
struct TripSettings {
  std::size_t there = 2000;                  ///< bytes
  std::size_t back = 2000;                   ///< bytes
  std::chrono::microseconds period{25'000};  ///< Between two of them.
  std::uint16_t port = 0;                    ///< Of the UDP echo; 0: any.
};

/// The other end, in a process of its own; runs until it is killed. The answer goes out from the thread that
/// is woken by the notifier, as in a service. 1 where the bus cannot be joined.
int echo_on_bus(const bus::BusOptions& options, const TripSettings& settings);
/// Prints its port first.
int echo_on_udp(const TripSettings& settings);

/// Round trips of messages that nobody reads, ms, until `is_over`: there as blocks of samples travel, back as
/// live estimates do (topics.hpp). One that is not back within 200 ms is lost, and is not among them.
[[nodiscard]] std::vector<double> bus_trips(const bus::BusOptions& options, const TripSettings& settings,
                                            const std::atomic<bool>& is_over);

/// The same by bare UDP on the loopback.
[[nodiscard]] std::vector<double> udp_trips(const TripSettings& settings, const std::atomic<bool>& is_over);

}  // namespace tonus::bench
