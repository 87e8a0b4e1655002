#include "rig_agent/agent/watchdog_process.hpp"

#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <new>
#include <spawn.h>
#include <spdlog/fmt/fmt.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>
#include <vector>

#include "rig_agent/agent/hold_reason.hpp"
#include "services/core/file_descriptor.hpp"
#include "services/core/installation.hpp"

namespace tonus::rig {
namespace {

constexpr int kPageInChild = 3;
constexpr std::chrono::seconds kLongestWithoutALook{1};

Error unavailable(const char* what, int error) {
  return fail(ErrorCode::kUnavailable,
              fmt::format("watchdog: {}: {}", what, std::generic_category().message(error)));
}

std::string program() { return (installation().helpers / "tonus-rig-watchdog").string(); }

/// Not by core/process: such a child ends with the thread that started it, and this one is there for the
/// agent that was killed.
Result<pid_t> spawn(std::vector<std::string> arguments, int page) {
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (auto& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, page, kPageInChild);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  // A group of its own: Ctrl-C at a terminal is not for it.
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  pid_t process = 0;
  const int error = posix_spawn(&process, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return unavailable(argv[0], error);
  return process;
}

}  // namespace

Result<std::unique_ptr<WatchdogProcess>> WatchdogProcess::start(const WatchdogOptions& options,
                                                                const Clock& clock) {
  const FileDescriptor page(memfd_create("tonus-pulse", MFD_CLOEXEC));
  if (!page.is_open() || ftruncate(page.get(), sizeof(control::Pulse)) != 0)
    return unavailable("no shared page", errno);
  void* memory = mmap(nullptr, sizeof(control::Pulse), PROT_READ | PROT_WRITE, MAP_SHARED, page.get(), 0);
  // NOLINTNEXTLINE(performance-no-int-to-ptr): the system's macro
  if (memory == MAP_FAILED) return unavailable("no shared page", errno);
  auto* pulse = new (memory) control::Pulse{};
  auto process =
      spawn({program(), std::to_string(kPageInChild), std::to_string(getpid()),
             std::to_string(std::lround(1e6 * options.limit)), std::to_string(options.fifo_priority),
             options.driver, options.driver_file, options.driver_options},
            page.get());
  if (!process) {
    munmap(memory, sizeof(control::Pulse));
    return process.error();
  }
  std::unique_ptr<WatchdogProcess> watchdog(new WatchdogProcess(pulse, *process, clock));
  // It has to look before anything may move.
  while (pulse->looks.load(std::memory_order_relaxed) == 0) {
    if (std::string problem = watchdog->problem(); !problem.empty())
      return fail(ErrorCode::kUnavailable, problem);
    usleep(1000);
  }
  return watchdog;
}

WatchdogProcess::~WatchdogProcess() {
  set_powered(false);
  pulse_->is_ending.store(1, std::memory_order_relaxed);
  if (process_ > 0 && pulse_->has_tripped.load(std::memory_order_relaxed) == 0) waitpid(process_, nullptr, 0);
  munmap(pulse_, sizeof(control::Pulse));
}

std::string WatchdogProcess::problem() {
  int status = 0;
  if (process_ > 0 && waitpid(process_, &status, WNOHANG) == process_) process_ = 0;
  if (process_ == 0) return phrase_of(HoldReason::kWatchdogEnded);
  const std::uint64_t looks = pulse_->looks.load(std::memory_order_relaxed);
  if (looks != looks_) {
    looks_ = looks;
    looked_at_ = clock_.now();
  }
  return clock_.now() - looked_at_ > kLongestWithoutALook ? phrase_of(HoldReason::kWatchdogStandsStill) : "";
}

}  // namespace tonus::rig
