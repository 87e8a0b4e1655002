#include "tests/fault/stop/stop_bench.hpp"

#include <csignal>
#include <spdlog/fmt/fmt.h>
#include <stdexcept>

#include "idl/topics.hpp"
#include "services/core/id.hpp"
#include "services/runtime/drain.hpp"
#include "services/runtime/options.hpp"
#include "tests/support/needed.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kPatience{60};
const Id kRig = id_of("rig/rig");

std::unique_ptr<bus::Bus> open_bus(const std::string& dds, int domain, const std::string& name) {
  runtime::CommonOptions common;
  common.dds = dds;
  common.domain = domain;
  return needed(runtime::open_bus(common, name));
}

/// The campaign itself, which is also what stands around the rig.
std::filesystem::path this_program() { return std::filesystem::read_symlink("/proc/self/exe"); }

}  // namespace

const char* name_of(Around around) {
  switch (around) {
    case Around::kQuiet:
      return "quiet";
    case Around::kStoppedFastDds:
      return "stopped reader, Fast DDS";
    case Around::kStoppedCycloneDds:
      return "stopped reader, Cyclone DDS";
    case Around::kDeaf:
      return "deaf client";
    case Around::kFlood:
      return "flood of commands";
    case Around::kFullSpool:
      return "full spool";
  }
  return "unknown";
}

StopBench::StopBench(const std::string& dds, Around around) : around_(around) {
  std::vector<std::string> arguments{"--driver", "simulated",
                                     "--speed",  "real",
                                     "--dds",    dds,
                                     "--domain", std::to_string(own_domain()),
                                     "--data",   (folder_ / "data").string()};
  if (around == Around::kFullSpool) arguments.insert(arguments.end(), {"--spool-MB", "1"});
  agent_ = std::make_unique<Process>(program("tonus-rig-agent"), arguments, folder_ / "agent");
  bus_ = open_bus(dds, own_domain(), "stop-bench");
  states_.emplace(needed(bus::TypedReader<v1::RigState>::create(*bus_, topics::kRigState, notifier_)));
  commands_.emplace(needed(bus::TypedWriter<v1::RigCommand>::create(*bus_, topics::kRigCommand)));
  sender_.emplace(needed(runtime::RigStopSender::create(open_bus(dds, own_domain(), "stop"), clock_)));
  if (!listen_until([this] { return state_ && state_->mode() != v1::RIG_STARTING; }))
    throw std::runtime_error("the rig is not heard: " + agent_->output());
  start_others(dds);
}

StopBench::~StopBench() {
  for (const auto& other : others_) other->signal(SIGCONT);
}

void StopBench::start_others(const std::string& dds) {
  switch (around_) {
    case Around::kQuiet:
      return;
    case Around::kStoppedFastDds:
      return start_other("listener", "fastdds", true);
    case Around::kStoppedCycloneDds:
      return start_other("listener", "cyclonedds", true);
    case Around::kDeaf:
      return start_other("deaf", dds, false);
    case Around::kFlood:
      return start_other("flood", dds, false);
    case Around::kFullSpool: {
      constexpr std::uint64_t kNearlyFull = 900'000;  // B, of the megabyte that it may have
      if (!listen_until([this] { return state_->spool_bytes() > kNearlyFull; }))
        throw std::runtime_error(fmt::format("the spool has {} bytes only", state_->spool_bytes()));
    }
  }
}

void StopBench::start_other(const std::string& role, const std::string& dds, bool stands_still) {
  const std::vector<std::string> arguments{"--as", role,       "--dds",
                                           dds,    "--domain", std::to_string(own_domain())};
  auto& other = others_.emplace_back(std::make_unique<Process>(this_program(), arguments, folder_ / role));
  if (!other->wait_for_output("matched", kPatience)) throw std::runtime_error(role + ": " + other->output());
  if (stands_still) other->signal(SIGSTOP);
}

bool StopBench::listen_until(const std::function<bool()>& is_true) {
  const auto patience = around_ == Around::kFullSpool ? 10 * kPatience : kPatience;
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (std::chrono::steady_clock::now() < deadline) {
    for (auto& heard : runtime::drain(*states_)) state_ = std::move(heard.value);
    if (is_true()) return true;
    (void)notifier_->wait_until(std::chrono::steady_clock::now() + std::chrono::milliseconds(20));
  }
  return false;
}

Result<void> StopBench::clear() {
  std::chrono::steady_clock::time_point asked{};
  const bool is_free = listen_until([&] {
    if (state_->mode() == v1::RIG_FREE) return true;
    // Refused while the handle still moves: ask again.
    if (const auto now = std::chrono::steady_clock::now(); now - asked > std::chrono::milliseconds(300)) {
      asked = now;
      v1::RigCommand command;
      command.rig_id(kRig);
      command.request_id(random_id());
      command.request(v1::RIG_CLEAR_FAULT);
      command.hold_number(state_->hold_number());
      command.requested_by("stop-bench");
      (void)commands_->write(command);
    }
    return false;
  });
  return is_free ? Result<void>{}
                 : fail(ErrorCode::kTimeout, "the rig is not cleared: " + state_->held_because());
}

Result<Clock::Duration> StopBench::stop() {
  TONUS_TRY(clear());
  TONUS_TRY_ASSIGN(const auto took, sender_->stop(kRig, random_id(), "stop-bench", kPatience));
  if (!listen_until([this] { return state_->mode() == v1::RIG_HELD; }))
    return fail(ErrorCode::kTimeout, "the rig does not say that it is held");
  return took;
}

Result<Clock::Duration> StopBench::stop_by_command() {
  TONUS_TRY(clear());
  const auto begun = std::chrono::steady_clock::now();
  Process command(program("tonus"), {"stop", "--domain", std::to_string(own_domain())}, folder_ / "stop");
  const int code = command.wait(kPatience);
  const auto took = std::chrono::steady_clock::now() - begun;
  if (code != 0) return fail(ErrorCode::kInternal, fmt::format("`tonus stop` ended with {}", code));
  if (!listen_until([this] { return state_->mode() == v1::RIG_HELD; }))
    return fail(ErrorCode::kTimeout, "the rig does not say that it is held");
  return std::chrono::duration_cast<Clock::Duration>(took);
}

int be(const std::string& role, const std::string& dds, int domain) {
  const auto notifier = std::make_shared<bus::Notifier>();
  const auto bus = open_bus(dds, domain, "stop-" + role);
  auto states = needed(bus::TypedReader<v1::RigState>::create(*bus, topics::kRigState, notifier));
  auto samples = needed(bus::TypedReader<v1::SampleBlock>::create(*bus, topics::kRigSamples, notifier));
  auto replies = needed(bus::TypedReader<v1::RigReply>::create(*bus, topics::kRigReply, notifier));
  auto commands = needed(bus::TypedWriter<v1::RigCommand>::create(*bus, topics::kRigCommand));
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (runtime::drain(states).empty()) {
    if (std::chrono::steady_clock::now() >= deadline) return 1;
    (void)notifier->wait_until(std::chrono::steady_clock::now() + std::chrono::milliseconds(20));
  }
  std::puts("matched");
  std::fflush(stdout);
  const bool is_flood = role == "flood";
  const int burst = is_flood ? 120 : 1;
  const auto period = std::chrono::milliseconds(is_flood ? 200 : 10);
  const pid_t parent = getppid();
  // Bounded: it ends with its parent, and in any case after half an hour.
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(30);
  while (getppid() == parent && std::chrono::steady_clock::now() < end) {
    for (int i = 0; role != "listener" && i < burst; ++i) {
      v1::RigCommand command;
      command.rig_id(kRig);
      command.request_id(random_id());
      command.request(v1::RIG_ABORT_TRIAL);
      command.trial_id(random_id());  // none that runs: refused, and answered
      command.requested_by(role);
      (void)commands.write(command);
    }
    (void)bus::Notifier().wait_until(std::chrono::steady_clock::now() + period);
  }
  return 0;
}

}  // namespace tonus::testing
