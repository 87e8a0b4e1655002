#include "tests/fuzz/packet_capture.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <linux/if_ether.h>
#include <poll.h>
#include <set>
#include <sstream>
#include <string>
#include <sys/socket.h>
#include <unistd.h>

namespace tonus::fuzz {
namespace {

constexpr std::size_t kUdpHeaderBytes = 8;

/// What an IP packet carries over UDP, where that begins as RTPS does; else empty.
Bytes rtps_in(const std::byte* packet, std::size_t size) {
  constexpr auto kUdp = static_cast<std::byte>(IPPROTO_UDP);
  if (size < 20 || packet[9] != kUdp) return {};
  const std::size_t begin = 4 * (static_cast<std::size_t>(packet[0]) & 0xfU) + kUdpHeaderBytes;
  if (size < begin + 20 || std::memcmp(packet + begin, "RTPS", 4) != 0) return {};
  return {packet + begin, packet + size};
}

}  // namespace

Result<std::vector<Bytes>> capture_rtps(std::chrono::milliseconds time, std::size_t most) {
  const int file = socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC, htons(ETH_P_IP));
  if (file < 0)
    return fail(ErrorCode::kUnavailable, std::string("packet socket failed: ") + std::strerror(errno));
  std::set<Bytes> different;
  std::vector<std::byte> buffer(70'000);
  const auto end = std::chrono::steady_clock::now() + time;
  for (auto now = std::chrono::steady_clock::now(); now < end && different.size() < most;
       now = std::chrono::steady_clock::now()) {
    pollfd waiting{file, POLLIN, 0};
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - now);
    if (poll(&waiting, 1, static_cast<int>(left.count()) + 1) <= 0) break;
    const ssize_t size = recv(file, buffer.data(), buffer.size(), 0);
    if (size <= 0) continue;
    Bytes bytes = rtps_in(buffer.data(), static_cast<std::size_t>(size));
    if (!bytes.empty()) different.insert(std::move(bytes));
  }
  close(file);
  return std::vector<Bytes>(different.begin(), different.end());
}

std::vector<std::uint16_t> udp_ports() {
  std::set<std::uint16_t> ports;
  std::ifstream in("/proc/self/net/udp");
  std::string line;
  std::getline(in, line);  // the heads of the columns
  while (std::getline(in, line)) {
    std::istringstream columns(line);
    std::string slot;
    std::string local;
    columns >> slot >> local;
    const auto colon = local.find(':');
    if (colon != std::string::npos)
      ports.insert(static_cast<std::uint16_t>(std::stoul(local.substr(colon + 1), nullptr, 16)));
  }
  return {ports.begin(), ports.end()};
}

PacketGun::PacketGun() : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}

PacketGun::~PacketGun() { close(socket_); }

void PacketGun::send(const Bytes& bytes, std::uint16_t port) const {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
  // A port whose owner is gone refuses: the owner is looked for elsewhere.
  (void)sendto(socket_, bytes.data(), std::min<std::size_t>(bytes.size(), 65'000), 0,
               reinterpret_cast<const sockaddr*>(&address), sizeof address);
}

}  // namespace tonus::fuzz
