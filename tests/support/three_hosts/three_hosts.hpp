#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {

/// The hosts of a lab: the PC beside the rig, the server of the services, the operator's desk.
enum class Host : std::size_t { kRig, kServer, kDesk };
inline constexpr std::array kHosts{Host::kRig, Host::kServer, Host::kDesk};

/// Three hosts with names, addresses and interfaces of their own, on a switch; nothing else is connected.
/// Each is a network namespace within the private network of this process (enter_private_network() comes
/// first), and all end with this object.
class ThreeHosts {
 public:
  /// kUnavailable: the system does not permit it, or ip, unshare, nsenter or nft is missing.
  [[nodiscard]] static Result<std::unique_ptr<ThreeHosts>> create();

  ~ThreeHosts();
  ThreeHosts(const ThreeHosts&) = delete;
  ThreeHosts& operator=(const ThreeHosts&) = delete;

  /// "rig-pc", "server", "desk".
  [[nodiscard]] static std::string name(Host host);
  /// 10.77.0.1 to 3.
  [[nodiscard]] static std::string address(Host host);

  /// The options of a program on that host: interface, and all addresses as peers.
  [[nodiscard]] static std::vector<std::string> peers_options(Host host);

  /// Starts a program of the system on a host.
  [[nodiscard]] std::unique_ptr<Process> start(Host host, const std::string& program,
                                               const std::vector<std::string>& arguments,
                                               const std::filesystem::path& output) const;

  /// Every host loses this share of the UDP packets that arrive; 0: none.
  [[nodiscard]] Result<void> lose_percent(int percent) const;
  /// Packets that were lost so far on all hosts.
  [[nodiscard]] Result<std::uint64_t> lost_packets() const;

  /// Pulls the host's cable, and plugs it in again.
  [[nodiscard]] Result<void> cut(Host host) const;
  [[nodiscard]] Result<void> connect(Host host) const;

  /// Runs a command of the system's on a host and waits for its end.
  [[nodiscard]] Result<void> run_on(Host host, const std::vector<std::string>& words) const;

 private:
  ThreeHosts() = default;
  [[nodiscard]] Result<void> set_up(Host host);
  [[nodiscard]] std::vector<std::string> entering(Host host) const;

  TemporaryFolder folder_;
  std::vector<std::unique_ptr<Process>> holders_;  ///< Each keeps its host's namespaces.
};

}  // namespace tonus::testing
