#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// What a host is and what it hears, as it was found. Not known is std::nullopt, never a zero.
namespace tonus::doctor {

struct ClockFacts {
  bool is_synchronised = false;
  double error_bound_s = 0.0;  ///< The kernel's own, where it is synchronised.
};

struct RealtimeFacts {
  int most_priority = 0;  ///< That this user may ask for; 0: none.
  bool has_unlimited_memory_lock = false;
  bool has_realtime_kernel = false;    ///< PREEMPT_RT.
  std::string kernel;                  ///< "6.1.0-18-amd64"
  std::vector<std::string> governors;  ///< Of the processors, each once; empty: no frequency scaling.
};

struct InterfaceFacts {
  std::string name;  ///< "eth0"; empty: the address is nobody's.
  std::string address;
  bool is_up = false;
  bool is_loopback = false;
  std::optional<int> speed_Mbit_per_s;
};

struct FirewallFacts {
  /// The ruleset as `nft list ruleset` prints it; none: it could not be read (needs root, or there is no
  /// nft).
  std::optional<std::string> rules;
};

struct PeerFacts {
  std::string name;     ///< As the option has it.
  std::string address;  ///< IPv4; empty: the name is not known here.
};

struct ServiceFacts {
  std::string role;
  std::string name;  ///< Of the rig.
  std::string host;
  std::string address;  ///< Of the host, where this one can look it up.
  bool is_ready = false;
  std::string state;
  std::string difference;  ///< Of contract or version from this program; empty: none.
  std::vector<std::string> warnings;
};

struct DiskFacts {
  std::string folder;
  std::string problem;  ///< Why nothing can be written there; empty: it can.
  std::uint64_t free_bytes = 0;
  std::chrono::nanoseconds median_sync{0};
  std::chrono::nanoseconds worst_sync{0};
};

/// A file or folder that matters, and who may use it.
struct PermissionFacts {
  std::string path;
  bool is_usable = true;  ///< By this user, for reading and writing.
  bool is_open_to_all = false;
  bool is_secret = false;  ///< A private key.
};

struct CertificateFacts {
  std::string path;
  std::string problem;  ///< Why it cannot be read; empty: it can.
  std::string common_name;
  std::chrono::hours left{0};
  bool is_revoked = false;
};

struct RigFacts {
  std::string driver;
  bool moves_nothing_real = false;
  double watchdog_s = 0.0;  ///< 0: none.
  std::vector<std::string> limits_off;
};

struct Facts {
  bool is_rig_host = false;
  std::vector<std::string> expected_roles;  ///< Whose health should be heard.
  std::string rig;
  int domain = 0;
  std::optional<ClockFacts> clock;
  std::optional<RealtimeFacts> realtime;
  std::optional<InterfaceFacts> interface;
  std::string network_problem;  ///< Why the options cannot be used; empty: they can.
  FirewallFacts firewall;
  std::vector<PeerFacts> peers;
  bool has_discovery_server = false;
  std::string bus_problem;  ///< Why the bus could not be joined; empty: it could.
  std::vector<ServiceFacts> services;
  std::uint64_t unreadable_reports = 0;  ///< Health that this program's contract cannot read.
  std::optional<RigFacts> described_rig;
  DiskFacts disk;
  std::vector<PermissionFacts> permissions;
  std::vector<CertificateFacts> certificates;
  bool is_secured = false;
};

/// First and last UDP port of a domain that two participants of this system use (RTPS 2.3, 9.6.1.1).
struct Ports {
  int first;
  int last;
};
[[nodiscard]] Ports ports_of(int domain);

}  // namespace tonus::doctor
