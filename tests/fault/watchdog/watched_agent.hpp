#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {

/// The example driver's amplifier (examples/driver/spring_rig.c), as another program sees it.
struct Amplifier {
  std::atomic<std::int32_t> is_enabled;
  std::atomic<std::int32_t> heartbeat;
  std::atomic<std::int64_t> disabled_ns;
  std::atomic<std::int64_t> written_ns;
  std::atomic<double> torque[2];
};

/// A rig agent alone, with the example driver, whose amplifier is a file. It ends after its watchdog has,
/// too: both have the file open.
class WatchedAgent {
 public:
  /// Waits until the loop writes torque; throws std::runtime_error with what the agent printed.
  explicit WatchedAgent(const std::string& driver_options = "");
  ~WatchedAgent();

  [[nodiscard]] Amplifier& amplifier() { return *amplifier_; }
  [[nodiscard]] Process& process() { return *agent_; }
  [[nodiscard]] std::string printed() const { return agent_->output(); }
  /// Starts the agent again, on the same rig; waits as the first time.
  void restart();

  /// Until the amplifier is no longer enabled: how long after `since` (CLOCK_MONOTONIC, ns); negative: not
  /// within `limit`.
  [[nodiscard]] std::int64_t time_to_off(std::int64_t since, std::chrono::seconds limit);

 private:
  void start();
  void end();

  const std::string driver_options_;
  int starts_ = 0;
  TemporaryFolder folder_;
  std::unique_ptr<Process> agent_;
  pid_t watchdog_ = 0;
  Amplifier* amplifier_ = nullptr;
};

[[nodiscard]] std::int64_t monotonic_ns();

}  // namespace tonus::testing
