#include "services/doctor/findings.hpp"

#include <algorithm>
#include <regex>
#include <set>
#include <spdlog/fmt/fmt.h>

#include "services/bus/discovery_limits.hpp"

namespace tonus::doctor {
namespace {

constexpr double kClockBound_s = 0.1;
constexpr int kLoopPriority = 80;                       // that the rig agent's unit asks for
constexpr std::uint64_t kLeastFreeBytes = 5ULL << 30U;  // some 30 hours of a 4 kHz session
constexpr std::chrono::milliseconds kLongSync{50};      // the archive syncs at least every 250 ms
constexpr std::chrono::milliseconds kTooLongSync{250};
constexpr std::chrono::hours kRenewWithin{24 * 30};

using Findings = std::vector<Finding>;

Finding ok(std::string subject, std::string text) {
  return {std::move(subject), Verdict::kOk, std::move(text), {}};
}
Finding advice(std::string subject, std::string text, std::string remedy) {
  return {std::move(subject), Verdict::kAdvice, std::move(text), std::move(remedy)};
}
Finding problem(std::string subject, std::string text, std::string remedy) {
  return {std::move(subject), Verdict::kProblem, std::move(text), std::move(remedy)};
}

double milliseconds(std::chrono::nanoseconds time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

void judge_clock(const Facts& facts, Findings& out) {
  if (!facts.clock) {
    out.push_back(advice("clock", "whether the clock is synchronised is not known",
                         "install chrony: apt install chrony"));
  } else if (!facts.clock->is_synchronised) {
    out.push_back(
        problem("clock", "the clock is not synchronised",
                "install chrony (apt install chrony), let all hosts follow one server, and wait until "
                "chronyc tracking says Normal"));
  } else if (facts.clock->error_bound_s > kClockBound_s) {
    out.push_back(advice(
        "clock", fmt::format("synchronised, wrong by up to {:.0f} ms", 1e3 * facts.clock->error_bound_s),
        "see chronyc sources: the server is far away or was found just now"));
  } else {
    out.push_back(
        ok("clock", fmt::format("synchronised, wrong by up to {:.1f} ms", 1e3 * facts.clock->error_bound_s)));
  }
}

void judge_realtime(const Facts& facts, Findings& out) {
  if (!facts.is_rig_host) {
    out.push_back(ok("realtime", "not needed: no rig agent on this host"));
    out.push_back(ok("kernel", "any: no rig agent on this host"));
    return;
  }
  if (!facts.realtime) {
    out.push_back(
        advice("realtime", "what this user may ask for is not known", "start the agent by systemd"));
    return;
  }
  const RealtimeFacts& realtime = *facts.realtime;
  if (realtime.most_priority >= kLoopPriority && realtime.has_unlimited_memory_lock) {
    out.push_back(
        ok("realtime", fmt::format("priority up to {}, memory may be locked", realtime.most_priority)));
  } else {
    out.push_back(
        problem("realtime",
                fmt::format("priority up to {} of {} needed, memory {} be locked", realtime.most_priority,
                            kLoopPriority, realtime.has_unlimited_memory_lock ? "may" : "may not"),
                "start the agent by systemd (tonus-rig.target), or give its user rtprio 80 and memlock "
                "unlimited in /etc/security/limits.d"));
  }
  const bool is_slow = std::any_of(realtime.governors.begin(), realtime.governors.end(),
                                   [](const std::string& governor) { return governor != "performance"; });
  if (!realtime.has_realtime_kernel) {
    out.push_back(advice("kernel", fmt::format("{} is no realtime kernel", realtime.kernel),
                         "apt install linux-image-rt-amd64, and measure missed periods with tonus status"));
  } else {
    out.push_back(ok("kernel", fmt::format("{} is a realtime kernel", realtime.kernel)));
  }
  if (is_slow) {
    out.push_back(advice("governor",
                         fmt::format("processors scale by '{}'", fmt::join(realtime.governors, "', '")),
                         "cpupower frequency-set -g performance"));
  } else {
    out.push_back(ok("governor", realtime.governors.empty() ? "processors do not scale" : "performance"));
  }
}

void judge_network(const Facts& facts, Findings& out) {
  if (!facts.network_problem.empty()) {
    out.push_back(
        problem("interface", facts.network_problem, "mend interface and peers in /etc/tonus/tonus.toml"));
    return;
  }
  if (!facts.interface) {
    out.push_back(
        advice("interface", "which interface the bus uses is not known", "name it with --interface"));
    return;
  }
  const InterfaceFacts& interface = *facts.interface;
  const std::string what = fmt::format("{} {}", interface.name, interface.address);
  if (!interface.is_up) {
    out.push_back(problem("interface", what + " is down",
                          "plug the cable in, or: ip link set " + interface.name + " up"));
  } else if (interface.is_loopback) {
    out.push_back(ok("interface", what + ": this machine only; other hosts need --interface and --peers"));
  } else if (interface.speed_Mbit_per_s && *interface.speed_Mbit_per_s < 100) {
    out.push_back(advice("interface", fmt::format("{} runs at {} Mbit/s", what, *interface.speed_Mbit_per_s),
                         "use a cable and a switch of 100 Mbit/s or more"));
  } else {
    out.push_back(ok("interface", what));
  }
}

/// Whether a rule accepts the ports by their numbers.
bool accepts(const std::string& rules, const Ports& ports) {
  const std::regex range(R"((\d+)-(\d+)[^\n]*accept)");
  for (std::sregex_iterator rule(rules.begin(), rules.end(), range), end; rule != end; ++rule) {
    if (std::stol((*rule)[1].str().substr(0, 9)) <= ports.first &&
        std::stol((*rule)[2].str().substr(0, 9)) >= ports.last)
      return true;
  }
  return false;
}

void judge_firewall(const Facts& facts, Findings& out) {
  const Ports ports = ports_of(facts.domain);
  const std::string needed =
      fmt::format("UDP {}-{}{}", ports.first, ports.last,
                  facts.has_discovery_server ? ", and 11811 on the discovery server" : "");
  const std::string remedy =
      fmt::format("nft add rule inet filter input ip saddr {{ THE PEERS }} udp dport {}-{} accept",
                  ports.first, ports.last);
  if (facts.interface && facts.interface->is_loopback) {
    out.push_back(ok("firewall", "not asked: this machine only"));
    return;
  }
  const auto& rules = facts.firewall.rules;
  if (!rules) {
    out.push_back(
        advice("firewall", "the rules cannot be read",
               fmt::format("as root, see nft list ruleset: {} from the peers must be accepted", needed)));
    return;
  }
  static const std::regex kFilters(R"(hook input[^}]*policy drop)");
  const bool is_filtered = std::regex_search(*rules, kFilters);
  if (!is_filtered) {
    out.push_back(ok("firewall", "input is not filtered; needed: " + needed));
  } else if (accepts(*rules, ports)) {
    out.push_back(ok("firewall", "accepts " + needed));
  } else {
    out.push_back(problem("firewall", "input is dropped, and no rule accepts " + needed, remedy));
  }
}

void judge_peers(const Facts& facts, Findings& out) {
  if (!facts.bus_problem.empty()) {
    out.push_back(problem("bus", facts.bus_problem, "mend the option that it names"));
    return;
  }
  if (facts.unreadable_reports > 0) {
    out.push_back(problem("versions",
                          fmt::format("{} reports of services cannot be read: another version is on the bus",
                                      facts.unreadable_reports),
                          "install one version on all hosts"));
  }
  for (const PeerFacts& peer : facts.peers) {
    const auto found =
        std::find_if(facts.services.begin(), facts.services.end(), [&](const ServiceFacts& service) {
          return service.host == peer.name || (!peer.address.empty() && service.address == peer.address);
        });
    const std::string what = "peer " + peer.name;
    if (peer.address.empty()) {
      out.push_back(problem("peers", what + " is a name that this host does not know",
                            "use its address, or add it to /etc/hosts"));
    } else if (found == facts.services.end()) {
      std::set<std::string> hosts;
      for (const auto& service : facts.services) hosts.insert(service.host);
      out.push_back(advice(
          "peers",
          fmt::format("{} ({}): nothing is known to come from it; services were heard from: {}", what,
                      peer.address, hosts.empty() ? "nobody" : fmt::format("{}", fmt::join(hosts, ", "))),
          "is a service running there with this host among its peers, and does its firewall accept us? "
          "Hosts' names should be in /etc/hosts"));
    } else {
      out.push_back(ok("peers", fmt::format("{} ({}): heard", what, peer.address)));
    }
  }
  for (const std::string& role : facts.expected_roles) {
    const auto found = std::find_if(facts.services.begin(), facts.services.end(),
                                    [&](const ServiceFacts& service) { return service.role == role; });
    if (found == facts.services.end()) {
      out.push_back(problem("services", fmt::format("{} of rig '{}' is not heard", role, facts.rig),
                            "start it: systemctl start tonus-lab.target or tonus-rig.target on its host"));
    } else if (!found->is_ready) {
      out.push_back(advice("services",
                           fmt::format("{} on {} is not ready: {}", role, found->host, found->state),
                           "do what it says"));
    } else {
      out.push_back(ok("services", fmt::format("{} on {}: {}", role, found->host, found->state)));
    }
  }
  bool is_same = true;
  for (const ServiceFacts& service : facts.services) {
    if (service.difference.empty()) continue;
    is_same = false;
    out.push_back(problem("versions", service.difference, "install one version on all hosts"));
  }
  if (is_same && facts.unreadable_reports == 0)
    out.push_back(
        ok("versions", fmt::format("{} services, one version and one contract", facts.services.size())));
}

void judge_disk(const Facts& facts, Findings& out) {
  const DiskFacts& disk = facts.disk;
  if (!disk.problem.empty()) {
    out.push_back(problem("disk", fmt::format("{}: {}", disk.folder, disk.problem),
                          "give this user the folder, or name another with --data"));
    return;
  }
  const std::string what = fmt::format("{}: {:.1f} GB free, sync {:.1f} ms, worst {:.1f} ms", disk.folder,
                                       static_cast<double>(disk.free_bytes) / 1e9,
                                       milliseconds(disk.median_sync), milliseconds(disk.worst_sync));
  if (disk.free_bytes < kLeastFreeBytes) {
    out.push_back(problem("disk", what, "make room: a session of 4 kHz writes about 0.2 GB an hour"));
  } else if (disk.median_sync > kTooLongSync) {
    out.push_back(problem("disk", what, "use a disk of its own, no network share and no SD card"));
  } else if (disk.worst_sync > kLongSync) {
    out.push_back(advice("disk", what, "other programs use this disk, or it is slow; receipts come late"));
  } else {
    out.push_back(ok("disk", what));
  }
}

void judge_permissions(const Facts& facts, Findings& out) {
  bool is_good = true;
  for (const PermissionFacts& file : facts.permissions) {
    if (!file.is_usable) {
      out.push_back(problem("permissions", file.path + " cannot be used by this user",
                            "chown it to the user of the services (tonus)"));
    } else if (file.is_open_to_all && file.is_secret) {
      out.push_back(problem("permissions", file.path + " is a private key that everybody can read",
                            "chmod o= " + file.path + ", then revoke and issue it anew"));
    } else if (file.is_open_to_all) {
      out.push_back(advice("permissions", file.path + " can be read by everybody", "chmod o= " + file.path));
    } else {
      continue;
    }
    is_good = false;
  }
  if (is_good)
    out.push_back(ok("permissions", fmt::format("{} files and folders", facts.permissions.size())));
}

void judge_certificates(const Facts& facts, Findings& out) {
  if (!facts.is_secured) {
    const bool is_loopback = facts.interface && facts.interface->is_loopback;
    out.push_back(is_loopback ? ok("certificates", "none: this machine only")
                              : advice("certificates", "none: everybody on the network can command the rig",
                                       "tonus pki init, then --security; or keep the lab's network apart"));
    return;
  }
  if (facts.certificates.empty())
    out.push_back(problem("certificates", "the folder of --security has no identity",
                          "tonus pki issue, and copy the host's folder"));
  for (const CertificateFacts& certificate : facts.certificates) {
    const auto days = certificate.left.count() / 24;
    if (!certificate.problem.empty()) {
      out.push_back(problem("certificates", certificate.path + ": " + certificate.problem,
                            "copy the host's folder anew"));
    } else if (certificate.is_revoked) {
      out.push_back(problem("certificates", certificate.common_name + " is revoked", "tonus pki issue"));
    } else if (certificate.left.count() <= 0) {
      out.push_back(problem("certificates",
                            fmt::format("{} has expired {} days ago", certificate.common_name, -days),
                            "tonus pki renew"));
    } else if (certificate.left < kRenewWithin) {
      out.push_back(advice("certificates", fmt::format("{} ends in {} days", certificate.common_name, days),
                           "tonus pki renew"));
    } else {
      out.push_back(
          ok("certificates", fmt::format("{} is valid for {} days", certificate.common_name, days)));
    }
  }
}

void judge_rig(const Facts& facts, Findings& out) {
  if (!facts.described_rig) {
    out.push_back(
        advice("rig", fmt::format("rig '{}' has not described itself", facts.rig), "start the rig agent"));
    return;
  }
  const RigFacts& rig = *facts.described_rig;
  if (rig.moves_nothing_real) {
    out.push_back(ok("rig", fmt::format("driver '{}' moves nobody", rig.driver)));
  } else if (rig.watchdog_s <= 0.0) {
    out.push_back(
        problem("rig", fmt::format("driver '{}' has no watchdog", rig.driver),
                "let the driver offer disable() or a watchdog of the device: rig_agent/drivers/README.md"));
  } else {
    out.push_back(
        ok("rig", fmt::format("driver '{}', watchdog after {:.0f} ms", rig.driver, 1e3 * rig.watchdog_s)));
  }
  if (!rig.limits_off.empty())
    out.push_back(advice("rig", fmt::format("limits that are off: {}", fmt::join(rig.limits_off, ", ")),
                         "switch them on in the rig's file"));
}

}  // namespace

Ports ports_of(int domain) {
  constexpr int kBase = 7400;
  constexpr int kPerDomain = 250;
  constexpr int kFirstUnicast = 10;
  const int first = kBase + kPerDomain * domain + kFirstUnicast;
  return {first, first + 2 * bus::kMaximumParticipantsPerHost - 1};
}

std::vector<Finding> judge(const Facts& facts) {
  Findings out;
  judge_clock(facts, out);
  judge_realtime(facts, out);
  judge_network(facts, out);
  judge_firewall(facts, out);
  judge_peers(facts, out);
  judge_disk(facts, out);
  judge_permissions(facts, out);
  judge_certificates(facts, out);
  judge_rig(facts, out);
  return out;
}

}  // namespace tonus::doctor
