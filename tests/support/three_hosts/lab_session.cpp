#include "tests/support/three_hosts/lab_session.hpp"

#include <algorithm>
#include <fstream>
#include <spdlog/fmt/fmt.h>
#include <sstream>

#include "services/store/open_store.hpp"
#include "tests/support/needed.hpp"
#include "tests/support/short_session.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kAnswerLimit{60};

}  // namespace

LabSession::LabSession(const ThreeHosts& hosts, LabOptions options)
    : hosts_(&hosts), options_(std::move(options)) {
  write_patient_profile(folder_ / "profile.toml");
  if (options_.has_discovery_server) services_.push_back(begin(Host::kServer, "tonus", {"discovery-server"}));
  services_.push_back(
      begin(Host::kServer, "tonus-archive", {"--idle-ring-s", "0"}));  // every sample is stored
  for (const char* service : {"tonus-identification", "tonus-scheduler"})
    services_.push_back(begin(Host::kServer, service, {}));
  std::vector<std::string> rig{"--speed", "real", "--profile", folder_ / "profile.toml"};
  if (options_.resumes_unattended) rig.emplace_back("--resume-unattended");
  services_.push_back(begin(Host::kRig, "tonus-rig-agent", rig));
}

std::vector<std::string> LabSession::options_of(Host host) const {
  std::vector<std::string> options = ThreeHosts::peers_options(host);
  if (options_.has_discovery_server)
    options = {"--interface", "lab0", "--discovery-servers", ThreeHosts::address(Host::kServer)};
  options.insert(options.end(), {"--data", folder_ / ThreeHosts::name(host), "--dds",
                                 options_.dds[static_cast<std::size_t>(host)]});
  if (!options_.security.empty())
    options.insert(options.end(), {"--security", options_.security / ThreeHosts::name(host)});
  return options;
}

std::unique_ptr<Process> LabSession::begin(Host host, const std::string& program,
                                           const std::vector<std::string>& more) {
  std::vector<std::string> arguments;
  if (program == "tonus") arguments.push_back(more.front());
  for (const auto& option : options_of(host)) arguments.push_back(option);
  arguments.insert(arguments.end(), more.begin() + (program == "tonus" ? 1 : 0), more.end());
  return hosts_->start(host, program, arguments, folder_ / fmt::format("{}.{}.log", ++programs_, program));
}

std::unique_ptr<Process> LabSession::start_beside(Host host, const std::string& program,
                                                  const std::vector<std::string>& more) {
  return begin(host, program, more);
}

void LabSession::start(int directions, int hold_s) {
  write_short_protocol(folder_ / "protocol.toml", directions, hold_s);
  run_ = begin(Host::kDesk, "tonus", {"run", folder_ / "protocol.toml"});
}

LabSession::Answer LabSession::ask(Host host, const std::string& command,
                                   const std::vector<std::string>& more) {
  std::vector<std::string> words{command};
  words.insert(words.end(), more.begin(), more.end());
  const auto process = begin(host, "tonus", words);
  const int code = process->wait(kAnswerLimit);
  return {code, process->output()};
}

bool LabSession::ask_until(Host host, const std::string& command, const std::string& text,
                           std::chrono::seconds limit) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  while (std::chrono::steady_clock::now() < deadline) {
    if (ask(host, command).text.find(text) != std::string::npos) return true;
  }
  return false;
}

store::Session LabSession::archived() const {
  auto store = needed(store::open_store_for_reading(store_file().string()));
  const auto record = needed(store::find_session(*store, "last"));
  return needed(store::read_session(*store, record.session));
}

std::string LabSession::everything_printed() const {
  std::vector<std::filesystem::path> logs;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "", error))
    if (entry.path().extension() == ".log") logs.push_back(entry.path());
  std::sort(logs.begin(), logs.end());
  std::string text;
  for (const auto& path : logs) {
    std::ifstream file(path);
    std::ostringstream log;
    log << file.rdbuf();
    text += "--- " + path.filename().string() + "\n" + log.str();
  }
  return text;
}

}  // namespace tonus::testing
