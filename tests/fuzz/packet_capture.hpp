#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "services/core/result.hpp"
#include "tests/fuzz/damage.hpp"

namespace tonus::fuzz {

/// The contents of different UDP packets that begin with "RTPS", heard on this network's loopback interface
/// for `time`, at most `most` of them. Needs the right to open packet sockets, which a private network gives.
[[nodiscard]] Result<std::vector<Bytes>> capture_rtps(std::chrono::milliseconds time, std::size_t most);

/// UDP ports on which anybody of this network listens.
[[nodiscard]] std::vector<std::uint16_t> udp_ports();

/// Sends packets to ports of 127.0.0.1.
class PacketGun {
 public:
  PacketGun();
  ~PacketGun();
  PacketGun(const PacketGun&) = delete;
  PacketGun& operator=(const PacketGun&) = delete;

  void send(const Bytes& bytes, std::uint16_t port) const;

 private:
  int socket_;
};

}  // namespace tonus::fuzz
