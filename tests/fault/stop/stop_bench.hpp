#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/bus/typed.hpp"
#include "services/core/clock.hpp"
#include "services/core/result.hpp"
#include "services/runtime/rig_stop.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

#include <idl/rig.h>

namespace tonus::testing {

/// What goes on around the rig while it is stopped.
enum class Around {
  kQuiet,
  kStoppedFastDds,  ///< A reader of all that the rig says, of this vendor, stands still (SIGSTOP).
  kStoppedCycloneDds,
  kDeaf,       ///< A client asks a hundred times a second and never takes a reply.
  kFlood,      ///< Bursts of 120 commands, five a second.
  kFullSpool,  ///< The agent's spool is full and nobody gives a receipt.
};

inline constexpr Around kAllAround[] = {Around::kQuiet, Around::kStoppedFastDds, Around::kStoppedCycloneDds,
                                        Around::kDeaf,  Around::kFlood,          Around::kFullSpool};

[[nodiscard]] const char* name_of(Around around);

/// A simulated rig in real time with one thing around it, stopped and cleared again and again.
class StopBench {
 public:
  /// Starts all of it; throws std::runtime_error where something does not come up.
  StopBench(const std::string& dds, Around around);
  ~StopBench();

  /// Clears the rig, then stops it through a participant that stands ready, as the gateway's for the pages:
  /// from the request until the rig's loop shows the stop.
  [[nodiscard]] Result<Clock::Duration> stop();
  /// The same by `tonus stop`, from its start to its end: discovery included.
  [[nodiscard]] Result<Clock::Duration> stop_by_command();

 private:
  void start_others(const std::string& dds);
  void start_other(const std::string& role, const std::string& dds, bool stands_still);
  [[nodiscard]] bool listen_until(const std::function<bool()>& is_true);
  [[nodiscard]] Result<void> clear();

  const Around around_;
  TemporaryFolder folder_;
  SystemClock clock_;
  std::unique_ptr<Process> agent_;
  std::vector<std::unique_ptr<Process>> others_;
  std::shared_ptr<bus::Notifier> notifier_ = std::make_shared<bus::Notifier>();
  std::unique_ptr<bus::Bus> bus_;
  std::optional<bus::TypedReader<v1::RigState>> states_;
  std::optional<bus::TypedWriter<v1::RigCommand>> commands_;
  std::optional<runtime::RigStopSender> sender_;
  std::optional<v1::RigState> state_;
};

/// What a process around the rig does, "listener", "deaf" or "flood", until its standard input ends.
int be(const std::string& role, const std::string& dds, int domain);

}  // namespace tonus::testing
