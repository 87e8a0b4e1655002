#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <ifaddrs.h>
#include <memory>

#include "services/bus/cyclonedds/cyclonedds_bus.hpp"
#include "services/bus/fastdds/fastdds_bus.hpp"
#include "services/bus/memory/memory_bus.hpp"
#include "services/bus/options_check.hpp"
#include "services/bus/partitions.hpp"
#include "services/bus/sanitizer_exceptions.hpp"
#include "services/bus/vendor_environment.hpp"

namespace tonus::bus {
namespace {

constexpr int kMaximumDomain = 232;  // RTPS 2.3, 9.6.1.1: ports of larger domains do not exist

Result<void> check_address(const char* what, const std::string& address) {
  in_addr parsed{};
  if (inet_pton(AF_INET, address.c_str(), &parsed) == 1) return {};
  return fail(
      ErrorCode::kInvalidArgument,
      std::string(what) + ": '" + address + "' is not allowed; expected an IPv4 address such as 127.0.0.1");
}

std::string dotted(const in_addr& address) {
  std::array<char, INET_ADDRSTRLEN> text{};
  inet_ntop(AF_INET, &address, text.data(), text.size());
  return text.data();
}

/// A character that means something in a pattern of partitions, or in a settings file of a carrier.
bool is_plain(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' || c == '.';
}

Result<void> check_partition(const std::string& partition) {
  if (std::all_of(partition.begin(), partition.end(), is_plain)) return {};
  return fail(ErrorCode::kInvalidArgument,
              "partition: '" + partition + "' is not allowed; expected letters, digits, '-', '_' and '.'");
}

/// For every carrier: the options are good, and the machine has the address.
Result<void> prepare(const BusOptions& options) {
  TONUS_TRY(check_options(options));
  // Fast DDS would carry on without any interface, and without a word.
  if (options.vendor != Vendor::kMemory) TONUS_TRY(own_address(options.network.interface_address));
  ignore_vendor_environment();
  return {};
}

Error unknown_vendor(const BusOptions& options) {
  return fail(ErrorCode::kInvalidArgument,
              "vendor " + std::to_string(static_cast<int>(options.vendor)) + ": unknown");
}

}  // namespace

Result<void> check_options(const BusOptions& options) {
  if (options.domain < 0 || options.domain > kMaximumDomain) {
    return fail(ErrorCode::kInvalidArgument, "domain: " + std::to_string(options.domain) +
                                                 " is not allowed; expected 0 to " +
                                                 std::to_string(kMaximumDomain));
  }
  if (options.participant_lease < std::chrono::milliseconds{100}) {
    return fail(ErrorCode::kInvalidArgument,
                "participant lease: " + std::to_string(options.participant_lease.count()) +
                    " ms is not allowed; expected at least 100 ms");
  }
  if (options.network.peers.empty()) {
    return fail(ErrorCode::kInvalidArgument, "peers: none is not allowed; expected at least one address");
  }
  if (auto good = check_address("interface address", options.network.interface_address); !good) return good;
  for (const std::string& peer : options.network.peers) {
    if (auto good = check_address("peer", peer); !good) return good;
  }
  for (const DiscoveryServerAddress& server : options.network.discovery_servers) {
    if (auto good = check_address("discovery server", server.address); !good) return good;
  }
  if (!options.network.discovery_servers.empty() && options.vendor == Vendor::kCycloneDds) {
    return fail(ErrorCode::kInvalidArgument, "discovery server " +
                                                 options.network.discovery_servers.front().address +
                                                 ": Cyclone DDS cannot use one; expected peers, or fastdds");
  }
  return check_partition(options.partition);
}

Result<Vendor> parse_vendor(std::string_view text) {
  for (const Vendor vendor : {Vendor::kMemory, Vendor::kFastDds, Vendor::kCycloneDds}) {
    if (text == vendor_name(vendor)) return vendor;
  }
  return fail(ErrorCode::kInvalidArgument, "DDS vendor: '" + std::string(text) +
                                               "' is not allowed; expected fastdds, cyclonedds or memory");
}

std::string_view vendor_name(Vendor vendor) {
  switch (vendor) {
    case Vendor::kMemory:
      return "memory";
    case Vendor::kFastDds:
      return "fastdds";
    case Vendor::kCycloneDds:
      return "cyclonedds";
  }
  return "unknown";
}

Result<std::string> own_address(const std::string& interface) {
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0)
    return fail(ErrorCode::kUnavailable, "list of interfaces failed: " + std::string(std::strerror(errno)));
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> list(first, freeifaddrs);
  in_addr parsed{};
  const bool is_address = inet_pton(AF_INET, interface.c_str(), &parsed) == 1;
  for (const ifaddrs* one = first; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    const in_addr own = reinterpret_cast<const sockaddr_in*>(one->ifa_addr)->sin_addr;
    if (is_address ? own.s_addr == parsed.s_addr : interface == one->ifa_name) return dotted(own);
  }
  return fail(ErrorCode::kUnavailable,
              is_address
                  ? "interface address " + interface + ": no interface of this machine has it"
                  : "interface '" + interface + "': this machine has none of that name with an IPv4 address");
}

Result<std::unique_ptr<Bus>> create_bus(const BusOptions& options) {
  TONUS_TRY(prepare(options));
  switch (options.vendor) {
    case Vendor::kMemory:
      return create_memory_bus(options);
    case Vendor::kFastDds:
      return create_fastdds_bus(options);
    case Vendor::kCycloneDds:
      return create_cyclonedds_bus(options);
  }
  return unknown_vendor(options);
}

Result<std::vector<std::unique_ptr<Bus>>> create_buses(const BusOptions& options,
                                                       const std::vector<Partitions>& places) {
  TONUS_TRY(prepare(options));
  for (const Partitions& partitions : places) {
    if (partitions.empty())
      return fail(ErrorCode::kInvalidArgument, "partitions: none is not allowed; expected at least one");
    for (const std::string& partition : partitions) TONUS_TRY(check_partition(partition));
  }
  switch (options.vendor) {
    case Vendor::kMemory: {
      std::vector<std::unique_ptr<Bus>> buses(places.size());
      for (auto& bus : buses) {
        TONUS_TRY_ASSIGN(bus, create_memory_bus(options));
      }
      return buses;
    }
    case Vendor::kFastDds:
      return create_fastdds_buses(options, places);
    case Vendor::kCycloneDds:
      return create_cyclonedds_buses(options, places);
  }
  return unknown_vendor(options);
}

}  // namespace tonus::bus
