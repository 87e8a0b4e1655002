#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "rig_agent/agent/agent.hpp"
#include "rig_agent/agent/loop_report.hpp"
#include "rig_agent/agent/rig.hpp"
#include "rig_agent/agent/safety_channel.hpp"
#include "services/runtime/health.hpp"

namespace tonus::rig {

/// What a run of the agent works with; all of it outlives the service.
struct RigServiceParts {
  Rig& rig;
  Spool& spool;
  TrialLog& log;
  HoldLatch& latch;
  const Clock& clock;
};

struct RigServiceOptions {
  bool is_paced = true;
  bool resumes_unattended = false;
  SafetyChannel::Works safety = SafetyChannel::Works::kInOwnThread;
};

/// One run of a rig's agent between the rig and two buses: the agent, its publisher, its stop channel, what
/// it reports of the loop and of itself. The loop's thread and the watchdog belong to the program. One thread
/// calls begin() once, then step().
class RigService {
 public:
  /// `safety_bus` is not shared with anything else; `notifier` is that of the thread that calls step(). The
  /// epoch is the time of this call.
  [[nodiscard]] static Result<std::unique_ptr<RigService>> create(
      bus::Bus& bus, std::unique_ptr<bus::Bus> safety_bus, const std::shared_ptr<bus::Notifier>& notifier,
      runtime::HealthReporter health, const RigServiceParts& parts, const RigServiceOptions& options);

  /// How the loop is run, as its report and the health have it.
  struct LoopStatement {
    std::string scheduling;                 ///< What the operating system permitted, one line.
    std::string refusal;                    ///< What it refused; empty: nothing.
    const control::Pacer* pacer = nullptr;  ///< Null where the loop is not paced.
  };

  /// Publishes what earlier runs left. Before the loop's thread is started.
  void start();
  /// The loop runs from now on.
  [[nodiscard]] Result<void> begin(const LoopStatement& statement);

  /// Handles all there is; returns when to call again at the latest. `watchdog_problem` holds the rig where
  /// it is not empty. The error: this process is the second of two agents.
  [[nodiscard]] Result<Clock::TimePoint> step(const std::string& watchdog_problem = {});

  [[nodiscard]] SafetyChannel& safety_channel() { return *safety_channel_; }
  [[nodiscard]] std::uint64_t epoch() const { return epoch_; }

 private:
  struct SampleWriters {
    std::unique_ptr<bus::Writer> samples;
    std::unique_ptr<bus::Writer> auxiliary;
  };
  RigService(runtime::HealthReporter health, const RigServiceParts& parts, std::uint64_t epoch,
             SampleWriters writers, bus::Bus& bus, const RigServiceOptions& options);

  RigServiceParts parts_;
  bus::Bus& bus_;
  const std::uint64_t epoch_;
  runtime::HealthReporter health_;
  Publisher publisher_;
  Lease lease_;
  StopRequests stops_;
  std::unique_ptr<SafetyChannel> safety_channel_;
  std::optional<Agent> agent_;
  std::optional<LoopReport> report_;
  std::string refusal_;
};

}  // namespace tonus::rig
