#include "tests/fault/watchdog/watched_agent.hpp"

#include <csignal>
#include <fcntl.h>
#include <fstream>
#include <stdexcept>
#include <sys/mman.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "tests/support/process.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kLimit{60};

template <typename Condition>
bool wait_until(Condition&& condition, std::chrono::seconds limit) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::yield();
  }
  return true;
}

/// Gone, or a zombie that nobody has waited for yet.
bool has_ended(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string line;
  if (!std::getline(file, line)) return true;
  return line.compare(line.rfind(')'), 3, ") Z") == 0;
}

}  // namespace

std::int64_t monotonic_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

WatchedAgent::WatchedAgent(const std::string& driver_options) : driver_options_(driver_options) {
  const auto file = folder_ / "amplifier";
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  void* page = ::ftruncate(descriptor, sizeof(Amplifier)) == 0
                   ? ::mmap(nullptr, sizeof(Amplifier), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0)
                   : MAP_FAILED;
  ::close(descriptor);
  if (page == MAP_FAILED) throw std::runtime_error("no page for the amplifier");
  amplifier_ = static_cast<Amplifier*>(page);
  start();
}

WatchedAgent::~WatchedAgent() {
  end();
  ::munmap(amplifier_, sizeof(Amplifier));
}

void WatchedAgent::start() {
  const std::int64_t before = monotonic_ns();
  agent_ = std::make_unique<Process>(
      program("tonus-rig-agent"),
      std::vector<std::string>{"--driver", "library", "--driver-file", TONUS_SPRING_RIG, "--driver-options",
                               "amplifier=" + (folder_ / "amplifier").string() + " " + driver_options_,
                               "--data", (folder_ / "data").string(), "--rig-folder",
                               (folder_ / "rig").string(), "--domain", std::to_string(own_domain())},
      folder_ / ("agent" + std::to_string(++starts_)));
  if (!wait_until([&] { return amplifier_->written_ns > before || amplifier_->disabled_ns > before; },
                  kLimit))
    throw std::runtime_error("the agent writes no torque: " + printed());
  watchdog_ = child_named(agent_->id(), "tonus-rig-watchdog");
}

// The watchdog sees by itself that its agent has ended.
void WatchedAgent::end() {
  agent_.reset();
  if (watchdog_ != 0) (void)wait_until([this] { return has_ended(watchdog_); }, kLimit);
  watchdog_ = 0;
}

void WatchedAgent::restart() {
  end();
  start();
}

std::int64_t WatchedAgent::time_to_off(std::int64_t since, std::chrono::seconds limit) {
  if (!wait_until([&] { return amplifier_->disabled_ns != 0 && amplifier_->is_enabled == 0; }, limit))
    return -1;
  return amplifier_->disabled_ns - since;
}

}  // namespace tonus::testing
