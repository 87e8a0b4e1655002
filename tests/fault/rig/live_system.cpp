#include "tests/fault/rig/live_system.hpp"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <spdlog/fmt/fmt.h>
#include <sstream>
#include <stdexcept>

#include "idl/topics.hpp"
#include "services/runtime/drain.hpp"
#include "services/runtime/options.hpp"
#include "services/store/open_store.hpp"
#include "tests/support/needed.hpp"
#include "tests/support/short_session.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kStartLimit{60};
/// What is done to the programs rejects trials, and a session that asks its operator because of that has not
/// failed to go on.
constexpr int kRejectionLimit = 1000;
constexpr double kHold_s = 1.5;
constexpr const char* kOthers[] = {"tonus-archive", "tonus-identification", "tonus-scheduler"};

}  // namespace

LiveSystem::LiveSystem(Unattended unattended, const std::string& dds, double command_timeout_s,
                       std::vector<std::string> more_options)
    : unattended_(unattended),
      dds_(dds),
      more_options_(std::move(more_options)),
      notifier_(std::make_shared<bus::Notifier>()) {
  ::setenv("TONUS_ARCHIVE_IDLE_RING_S", "0", 1);  // every sample is stored
  write_patient_profile(folder_ / "profile.toml", command_timeout_s);
  start_services();
  runtime::CommonOptions common;
  common.domain = own_domain();
  bus_ = needed(runtime::open_bus(common, "rig-fault-test"));
  states_.emplace(needed(bus::TypedReader<v1::RigState>::create(*bus_, topics::kRigState, notifier_)));
  timings_.emplace(needed(bus::TypedReader<v1::RigTiming>::create(*bus_, topics::kRigTiming, notifier_)));
  sessions_.emplace(
      needed(bus::TypedReader<v1::SessionState>::create(*bus_, topics::kSessionState, notifier_)));
}

void LiveSystem::start_services() {
  std::vector<std::string> arguments{"up",
                                     "--speed",
                                     "real",
                                     "--dds",
                                     dds_,
                                     "--domain",
                                     std::to_string(own_domain()),
                                     "--data",
                                     (folder_ / "data").string(),
                                     "--profile",
                                     (folder_ / "profile.toml").string()};
  if (unattended_ == Unattended::kYes) arguments.emplace_back("--resume-unattended");
  arguments.insert(arguments.end(), more_options_.begin(), more_options_.end());
  up_ =
      std::make_unique<Process>(program("tonus"), arguments, folder_ / ("up" + std::to_string(++commands_)));
  if (!up_->wait_for_output("ready after", kStartLimit))
    throw std::runtime_error("the services are not ready: " + everything_printed());
}

void LiveSystem::restart() {
  up_->signal(SIGTERM);
  (void)up_->wait(kStartLimit);
  up_.reset();
  start_services();
}

int LiveSystem::operate(const std::string& command) {
  Process process(program("tonus"), {command, "--domain", std::to_string(own_domain())},
                  folder_ / ("operator" + std::to_string(++commands_)));
  return process.wait(kStartLimit);
}

std::string LiveSystem::verify_session() {
  Process process(program("tonus"), {"verify", "--archive", store_file().string()},
                  folder_ / ("verify" + std::to_string(++commands_)));
  const int code = process.wait(kStartLimit);
  return code == 0 ? std::string() : fmt::format("`tonus verify` ended with {}:\n{}", code, process.output());
}

void LiveSystem::start_session(int directions) {
  write_short_protocol(folder_ / "protocol.toml", directions, kHold_s, kRejectionLimit);
  run_ = std::make_unique<Process>(
      program("tonus"),
      std::vector<std::string>{"run", (folder_ / "protocol.toml").string(), "--domain",
                               std::to_string(own_domain()), "--data", (folder_ / "data").string()},
      folder_ / "run");
}

int LiveSystem::finish_session(std::chrono::seconds limit) { return run_->wait(limit); }

void LiveSystem::hear() {
  for (auto& heard : runtime::drain(*states_)) state_ = std::move(heard.value);
  for (auto& heard : runtime::drain(*timings_)) timing_ = std::move(heard.value);
  for (auto& heard : runtime::drain(*sessions_)) session_ = std::move(heard.value);
}

bool LiveSystem::listen_until(const std::function<bool()>& is_true, std::chrono::seconds limit) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  while (std::chrono::steady_clock::now() < deadline) {
    hear();
    if (is_true()) return true;
    (void)notifier_->wait_until(std::chrono::steady_clock::now() + std::chrono::milliseconds(20));
  }
  return false;
}

bool LiveSystem::wait_for_mid_trial(std::uint64_t samples, std::chrono::seconds limit) {
  std::optional<v1::RigState> first;
  return listen_until(
      [&] {
        if (!state_ || state_->mode() != v1::RIG_IN_TRIAL) return first.reset(), false;
        if (!first || first->trial_id() != state_->trial_id()) first = state_;
        return state_->next_sequence() >= first->next_sequence() + samples;
      },
      limit);
}

pid_t LiveSystem::service(const std::string& name) const { return child_named(up_->id(), name); }

void LiveSystem::signal_others(int signal) const {
  for (const char* name : kOthers) {
    if (const pid_t process = service(name); process != 0) kill(process, signal);
  }
  if (run_) run_->signal(signal);
}

store::Session LiveSystem::archived() const {
  auto store = needed(store::open_store_for_reading(store_file().string()));
  const auto record = needed(store::find_session(*store, "last"));
  return needed(store::read_session(*store, record.session));
}

std::uint64_t LiveSystem::spooled_bytes() const {
  std::uint64_t bytes = 0;
  std::error_code error;
  for (const auto& entry :
       std::filesystem::directory_iterator(folder_ / "data" / "rig" / "rig" / "spool", error))
    bytes += entry.file_size(error);
  return bytes;
}

std::string LiveSystem::everything_printed() const {
  std::string text = up_->output() + (run_ ? run_->output() : "");
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "data" / "logs", error)) {
    std::ifstream file(entry.path());
    std::ostringstream log;
    log << file.rdbuf();
    text += "--- " + entry.path().filename().string() + "\n" + log.str();
  }
  return text;
}

std::string missing_samples(const std::filesystem::path& store_file) {
  auto store = needed(store::open_store_for_reading(store_file.string()));
  const auto streams = needed(store->streams());
  if (streams.empty()) return "there are no streams";
  for (const auto& stream : streams) {
    if (stream.coverage.ranges().size() != 1)
      return fmt::format("stream {} is covered in {} pieces", stream.key.epoch,
                         stream.coverage.ranges().size());
    const auto whole = stream.coverage.ranges().front();
    if (whole.first != stream.origin)
      return fmt::format("stream {} begins at {}, not at {}", stream.key.epoch, whole.first, stream.origin);
    std::uint64_t next = whole.first;
    std::string gap;
    const auto visited =
        store->visit_blocks({stream.key, whole}, [&](const store::Block& block) -> Result<void> {
          if (block.first_sequence > next)
            gap = fmt::format("stream {}: no block has {}", stream.key.epoch, next);
          next = std::max(next, block.range().end);
          return {};
        });
    if (!visited) return visited.error().message;
    if (!gap.empty()) return gap;
    if (next != whole.end)
      return fmt::format("stream {} ends at {}, not at {}", stream.key.epoch, next, whole.end);
  }
  return {};
}

}  // namespace tonus::testing
