#include "services/doctor/host_facts.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <ifaddrs.h>
#include <memory>
#include <net/if.h>
#include <set>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/timex.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "services/core/file_descriptor.hpp"
#include "services/core/folder.hpp"
#include "services/core/process.hpp"
#include "services/core/text_file.hpp"
#include "services/pki/certificate.hpp"
#include "services/runtime/network.hpp"

namespace tonus::doctor {
namespace {

constexpr int kSyncs = 20;
constexpr std::size_t kSyncedBytes = 4096;

std::string first_line(const std::filesystem::path& file) {
  const auto text = read_text_file(file, 4096);
  return text ? text->substr(0, text->find('\n')) : std::string();
}

std::optional<ClockFacts> clock_facts() {
  timex state{};
  const int code = adjtimex(&state);
  if (code < 0) return std::nullopt;
  return ClockFacts{code != TIME_ERROR && (state.status & STA_UNSYNC) == 0,
                    1e-6 * static_cast<double>(state.maxerror)};
}

RealtimeFacts realtime_facts() {
  RealtimeFacts facts;
  rlimit limit{};
  if (geteuid() == 0) {
    facts.most_priority = 99;
  } else if (getrlimit(RLIMIT_RTPRIO, &limit) == 0) {
    facts.most_priority = static_cast<int>(std::min<rlim_t>(limit.rlim_cur, 99));
  }
  facts.has_unlimited_memory_lock =
      geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
  facts.has_realtime_kernel = first_line("/sys/kernel/realtime") == "1";
  utsname system{};
  if (uname(&system) == 0) facts.kernel = system.release;
  std::set<std::string> governors;
  if (const auto processors = list_folder("/sys/devices/system/cpu")) {
    for (const auto& processor : *processors) {
      const std::string governor = first_line(processor / "cpufreq" / "scaling_governor");
      if (!governor.empty()) governors.insert(governor);
    }
  }
  facts.governors.assign(governors.begin(), governors.end());
  return facts;
}

std::optional<InterfaceFacts> interface_facts(const std::string& address) {
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return std::nullopt;
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> list(first, freeifaddrs);
  in_addr wanted{};
  inet_pton(AF_INET, address.c_str(), &wanted);
  for (const ifaddrs* one = first; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    if (reinterpret_cast<const sockaddr_in*>(one->ifa_addr)->sin_addr.s_addr != wanted.s_addr) continue;
    InterfaceFacts facts{.name = one->ifa_name,
                         .address = address,
                         .is_up = (one->ifa_flags & IFF_RUNNING) != 0,
                         .is_loopback = (one->ifa_flags & IFF_LOOPBACK) != 0,
                         .speed_Mbit_per_s = {}};
    const std::string speed = first_line("/sys/class/net/" + facts.name + "/speed");
    if (!speed.empty() && std::isdigit(static_cast<unsigned char>(speed.front())) != 0)
      facts.speed_Mbit_per_s = std::atoi(speed.c_str());
    return facts;
  }
  return std::nullopt;
}

FirewallFacts firewall_facts() {
  if (!find_program("nft")) return {};
  std::unique_ptr<FILE, int (*)(FILE*)> output(std::tmpfile(), std::fclose);
  if (!output) return {};
  const auto end = run_process({"nft", "list", "ruleset"}, {fileno(output.get()), {}, {}});
  if (!end || !end->is_success()) return {};
  std::string rules;
  std::rewind(output.get());
  std::array<char, 4096> part{};
  while (const std::size_t count = std::fread(part.data(), 1, part.size(), output.get()))
    rules.append(part.data(), count);
  return {std::move(rules)};
}

DiskFacts disk_facts(const std::filesystem::path& folder) {
  DiskFacts facts;
  facts.folder = folder.string();
  std::error_code error;
  const auto space = std::filesystem::space(folder, error);
  if (error) {
    facts.problem = error.message();
    return facts;
  }
  facts.free_bytes = space.available;
  std::string path = (folder / ".doctor-XXXXXX").string();
  const FileDescriptor file(mkostemp(path.data(), O_CLOEXEC));
  if (!file.is_open()) {
    facts.problem = std::string("cannot be written: ") + std::strerror(errno);
    return facts;
  }
  unlink(path.c_str());
  const std::string text(kSyncedBytes, 'x');
  std::vector<std::chrono::nanoseconds> times;
  for (int i = 0; i < kSyncs; ++i) {
    const auto begun = std::chrono::steady_clock::now();
    if (write(file.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size()) ||
        fdatasync(file.get()) != 0) {
      facts.problem = std::string("cannot be written: ") + std::strerror(errno);
      return facts;
    }
    times.push_back(std::chrono::steady_clock::now() - begun);
  }
  std::sort(times.begin(), times.end());
  facts.median_sync = times[times.size() / 2];
  facts.worst_sync = times.back();
  return facts;
}

void add_permissions(const std::filesystem::path& path, bool is_secret, bool is_written,
                     std::vector<PermissionFacts>& out) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) {
    if (errno != ENOENT) out.push_back({path.string(), false, false, is_secret});
    return;  // what is not there yet is made with the right rights
  }
  const int wanted = R_OK | (is_written ? W_OK : 0) | (S_ISDIR(info.st_mode) ? X_OK : 0);
  out.push_back({path.string(), access(path.c_str(), wanted) == 0, (info.st_mode & (S_IROTH | S_IWOTH)) != 0,
                 is_secret});
}

void find_certificates(const std::filesystem::path& folder, Facts& facts) {
  std::vector<std::uint64_t> revoked;
  if (const auto list = read_text_file(folder / "revoked.pem")) {
    if (auto serials = pki::read_revocations(*list)) revoked = *std::move(serials);
  }
  const auto entries = list_folder(folder);
  if (!entries) {
    facts.certificates.push_back(
        {.path = folder.string(), .problem = entries.error().message, .common_name = {}});
    return;
  }
  for (const auto& identity : *entries) {
    std::error_code error;
    if (!std::filesystem::is_directory(identity, error)) continue;
    CertificateFacts found;
    found.path = (identity / "certificate.pem").string();
    const auto text = read_text_file(found.path);
    const auto state = text ? pki::read_certificate(*text) : Result<pki::CertificateState>(text.error());
    if (!state) {
      found.problem = state.error().message;
    } else {
      found.common_name = state->common_name;
      found.left = std::chrono::floor<std::chrono::hours>(state->end - std::chrono::system_clock::now());
      found.is_revoked = std::find(revoked.begin(), revoked.end(), state->serial) != revoked.end();
    }
    facts.certificates.push_back(std::move(found));
    add_permissions(identity / "key.pem", true, false, facts.permissions);
  }
}

}  // namespace

void find_host_facts(const runtime::CommonOptions& options, Facts& facts) {
  facts.rig = options.rig;
  facts.domain = options.domain;
  facts.clock = clock_facts();
  facts.realtime = realtime_facts();
  facts.has_discovery_server = !options.discovery_servers.empty();
  facts.firewall = firewall_facts();
  const auto network = runtime::network_profile(options);
  if (network) {
    facts.interface = interface_facts(network->interface_address);
  } else {
    facts.network_problem = network.error().message;
  }
  for (const std::string& peer : options.peers) {
    const std::string address = runtime::address_of_host(peer).value_or("");
    if (!facts.interface || address != facts.interface->address) facts.peers.push_back({peer, address});
  }
  const auto data = runtime::data_folder(options);
  if (data) {
    facts.disk = disk_facts(*data);
    add_permissions(*data, false, true, facts.permissions);
    add_permissions(*data / "rig" / options.rig / "hold", false, true, facts.permissions);
  } else {
    facts.disk.folder = options.data;
    facts.disk.problem = data.error().message;
  }
  facts.is_secured = !options.security.empty();
  if (facts.is_secured) find_certificates(options.security, facts);
}

}  // namespace tonus::doctor
