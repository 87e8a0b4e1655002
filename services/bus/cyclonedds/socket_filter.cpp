#include "services/bus/cyclonedds/socket_filter.hpp"

#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <linux/filter.h>
#include <sys/socket.h>

namespace tonus::bus {
namespace {

constexpr int kFirstPort = 7400;  // RTPS 2.3, 9.6.1.1
constexpr int kPortsOfADomain = 250;

bool is_of_domain(int file, int domain) {
  int protocol = 0;
  socklen_t size = sizeof protocol;
  if (getsockopt(file, SOL_SOCKET, SO_PROTOCOL, &protocol, &size) != 0 || protocol != IPPROTO_UDP)
    return false;
  sockaddr_in bound{};
  size = sizeof bound;
  if (getsockname(file, reinterpret_cast<sockaddr*>(&bound), &size) != 0) return false;
  const int first = kFirstPort + kPortsOfADomain * domain;
  const int port = ntohs(bound.sin_port);
  return bound.sin_family == AF_INET && bound.sin_addr.s_addr == INADDR_ANY && port >= first &&
         port < first + kPortsOfADomain;
}

/// Of an earlier participant of this process, which may be on another interface.
bool has_filter(int file) {
  socklen_t instructions = 0;
  return getsockopt(file, SOL_SOCKET, SO_GET_FILTER, nullptr, &instructions) == 0 && instructions > 0;
}

/// Takes a packet whole where the destination of its IP header is `address`, else nothing of it.
bool attach(int file, in_addr address) {
  constexpr std::uint32_t kDestination = 16;  // bytes into the IPv4 header
  constexpr std::uint32_t kWhole = 0xffffffff;
  std::array<sock_filter, 4> code{
      sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(SKF_NET_OFF) + kDestination),
      sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, ntohl(address.s_addr), 0, 1),
      sock_filter BPF_STMT(BPF_RET | BPF_K, kWhole), sock_filter BPF_STMT(BPF_RET | BPF_K, 0)};
  const sock_fprog program{static_cast<unsigned short>(code.size()), code.data()};
  return setsockopt(file, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) == 0;
}

}  // namespace

Result<std::size_t> accept_only_at(const std::string& interface_address, int domain) {
  in_addr address{};
  inet_pton(AF_INET, interface_address.c_str(), &address);
  std::size_t count = 0;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    const std::string name = entry.path().filename();
    int file = -1;
    std::from_chars(name.data(), name.data() + name.size(), file);
    if (file < 0 || !is_of_domain(file, domain) || has_filter(file)) continue;
    if (!attach(file, address)) {
      return fail(ErrorCode::kUnavailable, "Cyclone DDS: its sockets could not be confined to " +
                                               interface_address + ": " + std::strerror(errno));
    }
    ++count;
  }
  if (error) return fail(ErrorCode::kUnavailable, "/proc/self/fd: " + error.message());
  return count;
}

}  // namespace tonus::bus
