#include "services/runtime/network.hpp"

#include <arpa/inet.h>
#include <array>
#include <charconv>
#include <memory>
#include <netdb.h>
#include <spdlog/fmt/fmt.h>
#include <sys/socket.h>

namespace tonus::runtime {
namespace {

/// The IPv4 address, dotted, of a host that is named by itself or by its address.
Result<std::string> address_of(const std::string& host, const char* option) {
  addrinfo wanted{};
  wanted.ai_family = AF_INET;
  wanted.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (const int code = getaddrinfo(host.c_str(), nullptr, &wanted, &found); code != 0) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("{}: '{}': {}; expected an IPv4 address or a name that this host knows", option,
                            host, gai_strerror(code)));
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> list(found, freeaddrinfo);
  std::array<char, INET_ADDRSTRLEN> text{};
  const auto* address = reinterpret_cast<const sockaddr_in*>(list->ai_addr);
  inet_ntop(AF_INET, &address->sin_addr, text.data(), text.size());
  return std::string(text.data());
}

Result<bus::DiscoveryServerAddress> server_of(const std::string& text) {
  bus::DiscoveryServerAddress server;
  const auto colon = text.find(':');
  if (colon != std::string::npos) {
    const char* end = text.data() + text.size();
    const auto [stop, code] = std::from_chars(text.data() + colon + 1, end, server.port);
    if (code != std::errc() || stop != end || server.port == 0) {
      return fail(
          ErrorCode::kInvalidArgument,
          fmt::format(
              "--discovery-servers: '{}' is not allowed; expected ADDRESS or ADDRESS:PORT, port 1 to 65535",
              text));
    }
  }
  TONUS_TRY_ASSIGN(server.address, address_of(text.substr(0, colon), "--discovery-servers"));
  return server;
}

}  // namespace

Result<bus::NetworkProfile> network_profile(const CommonOptions& options) {
  bus::NetworkProfile network;
  if (options.interface.empty()) {
    if (!options.peers.empty() || !options.discovery_servers.empty()) {
      return fail(ErrorCode::kInvalidArgument,
                  "--interface is missing; expected the lab's network interface beside --peers or "
                  "--discovery-servers");
    }
    return network;
  }
  if (!options.security.empty() && !options.discovery_servers.empty()) {
    return fail(
        ErrorCode::kInvalidArgument,
        "--discovery-servers: not allowed in a secured domain, whose members know each other by their "
        "certificates; expected --peers");
  }
  auto address = bus::own_address(options.interface);
  if (!address) return fail(address.error().code, "--interface: " + address.error().message);
  network.interface_address = *address;
  network.peers = {*address};
  for (const std::string& peer : options.peers) {
    TONUS_TRY_ASSIGN(auto peer_address, address_of(peer, "--peers"));
    if (peer_address != *address) network.peers.push_back(std::move(peer_address));
  }
  for (const std::string& text : options.discovery_servers) {
    TONUS_TRY_ASSIGN(auto server, server_of(text));
    network.discovery_servers.push_back(std::move(server));
  }
  return network;
}

std::optional<std::string> address_of_host(const std::string& host) {
  auto address = address_of(host, "");
  if (!address) return std::nullopt;
  return *std::move(address);
}

}  // namespace tonus::runtime
