#pragma once

#include <cstdint>
#include <string>

#include "services/core/result.hpp"

namespace tonus::fuzz {

/// What is sent to the ports and topics of a whole running system.
struct BusAttack {
  std::string dds = "fastdds";
  std::uint64_t seed = 1;
  std::uint64_t packets = 200'000;   ///< Captured RTPS packets, mutated, to every port.
  std::uint64_t messages = 200'000;  ///< Messages of every topic with mutated contents.
  bool shows_progress = false;
};

struct BusAttackReport {
  std::uint64_t captured = 0;  ///< Different packets that the mutations begin with.
  std::uint64_t ports = 0;
  std::uint64_t packets = 0;   ///< Sent, each to one port.
  std::uint64_t messages = 0;  ///< That the bus took for sending.
  std::uint64_t refused = 0;   ///< That it did not: no key, or no room.
  std::string largest;         ///< The program whose memory grew most.
  double growth_MB = 0.0;      ///< Of that one, above what it had before.
};

/// Starts `tonus up` and a session in this process's own network, which must be private, captures what its
/// programs say, and attacks them. An error where a program ended or was replaced, or grew by more than 64
/// MB.
[[nodiscard]] Result<BusAttackReport> attack_bus(const BusAttack& attack);

[[nodiscard]] std::string text_of(const BusAttackReport& report);

}  // namespace tonus::fuzz
