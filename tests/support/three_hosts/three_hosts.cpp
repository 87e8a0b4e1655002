#include "tests/support/three_hosts/three_hosts.hpp"

#include <fstream>
#include <spdlog/fmt/fmt.h>
#include <sstream>

#include "services/core/process.hpp"
#include "tests/support/bus/eventually.hpp"
#include "tests/support/bus/private_network.hpp"

namespace tonus::testing {
namespace {

using tonus::test::run_program;

constexpr const char* kNames[] = {"rig-pc", "server", "desk"};

std::size_t index(Host host) { return static_cast<std::size_t>(host); }
std::string port(Host host) { return fmt::format("port{}", index(host)); }

std::string namespace_of(pid_t process, const char* kind) {
  std::error_code error;
  return std::filesystem::read_symlink(fmt::format("/proc/{}/ns/{}", process, kind), error).string();
}

std::filesystem::path needed_program(const std::string& name) {
  return find_program(name).value_or(std::filesystem::path(name));
}

}  // namespace

std::string ThreeHosts::name(Host host) { return kNames[index(host)]; }

std::string ThreeHosts::address(Host host) { return fmt::format("10.77.0.{}", index(host) + 1); }

std::vector<std::string> ThreeHosts::peers_options(Host host) {
  std::string peers;
  for (const Host other : kHosts) peers += (peers.empty() ? "" : ",") + address(other);
  return {"--interface", address(host), "--peers", peers};
}

Result<std::unique_ptr<ThreeHosts>> ThreeHosts::create() {
  if (!tonus::test::is_in_private_network())
    return fail(ErrorCode::kUnavailable,
                "needs a network namespace of its own, which this system does not permit");
  std::unique_ptr<ThreeHosts> hosts(new ThreeHosts);
  TONUS_TRY(run_program({"ip", "link", "add", "switch", "type", "bridge", "mcast_snooping", "0"}));
  TONUS_TRY(run_program({"ip", "link", "set", "switch", "up"}));
  for (const Host host : kHosts) TONUS_TRY(hosts->set_up(host));
  return hosts;
}

ThreeHosts::~ThreeHosts() {
  // A namespace ends some time after its last process: its cable must not be in the way of the next lab's.
  for (std::size_t i = 0; i < holders_.size(); ++i)
    (void)run_program({"ip", "link", "delete", port(kHosts[i])});
  holders_.clear();
  (void)run_program({"ip", "link", "delete", "switch"});
}

Result<void> ThreeHosts::set_up(Host host) {
  holders_.push_back(std::make_unique<Process>(
      needed_program("unshare"),
      std::vector<std::string>{"--net", "--uts", "sh", "-c",
                               "hostname " + name(host) + " && echo ready && exec sleep infinity"},
      folder_ / name(host)));
  const pid_t holder = holders_.back()->id();
  if (!holders_.back()->wait_for_output("ready", std::chrono::seconds(20)) ||
      namespace_of(holder, "net") == namespace_of(getpid(), "net"))
    return fail(ErrorCode::kUnavailable, "unshare made no host: " + holders_.back()->output());
  TONUS_TRY(run_program({"ip", "link", "add", port(host), "type", "veth", "peer", "name", "lab0", "netns",
                         std::to_string(holder)}));
  TONUS_TRY(run_program({"ip", "link", "set", port(host), "master", "switch", "up"}));
  TONUS_TRY(run_on(host, {"ip", "link", "set", "lo", "up"}));
  TONUS_TRY(run_on(host, {"ip", "addr", "add", address(host) + "/24", "dev", "lab0"}));
  return run_on(host, {"ip", "link", "set", "lab0", "up"});
}

std::vector<std::string> ThreeHosts::entering(Host host) const {
  const pid_t holder = holders_[index(host)]->id();
  return {fmt::format("--net=/proc/{}/ns/net", holder), fmt::format("--uts=/proc/{}/ns/uts", holder), "--"};
}

Result<void> ThreeHosts::run_on(Host host, const std::vector<std::string>& words) const {
  std::vector<std::string> all{"nsenter"};
  for (const auto& word : entering(host)) all.push_back(word);
  all.insert(all.end(), words.begin(), words.end());
  return run_program(all);
}

std::unique_ptr<Process> ThreeHosts::start(Host host, const std::string& name,
                                           const std::vector<std::string>& arguments,
                                           const std::filesystem::path& output) const {
  auto words = entering(host);
  words.push_back(program(name).string());
  words.insert(words.end(), arguments.begin(), arguments.end());
  return std::make_unique<Process>(needed_program("nsenter"), words, output);
}

Result<void> ThreeHosts::lose_percent(int percent) const {
  for (const Host host : kHosts) {
    // The counters go on over changes of the share.
    TONUS_TRY(
        run_on(host, {"nft",
                      "add table inet loss; add counter inet loss lost; add chain inet loss input { type "
                      "filter hook input priority 0; }; flush chain inet loss input"}));
    if (percent == 0) continue;
    TONUS_TRY(run_on(
        host, {"nft", fmt::format("add rule inet loss input iifname lab0 meta l4proto udp numgen random "
                                  "mod 100 < {} counter name lost drop",
                                  percent)}));
  }
  return {};
}

Result<std::uint64_t> ThreeHosts::lost_packets() const {
  std::uint64_t lost = 0;
  for (const Host host : kHosts) {
    const auto file = folder_ / ("lost" + name(host));
    TONUS_TRY(run_on(host, {"sh", "-c", "nft list counter inet loss lost > " + file.string()}));
    std::ifstream in(file);
    for (std::string word; in >> word;) {
      std::uint64_t count = 0;
      if (word == "packets" && in >> count) lost += count;
    }
  }
  return lost;
}

Result<void> ThreeHosts::cut(Host host) const {
  return run_program({"ip", "link", "set", port(host), "down"});
}

Result<void> ThreeHosts::connect(Host host) const {
  return run_program({"ip", "link", "set", port(host), "up"});
}

}  // namespace tonus::testing
