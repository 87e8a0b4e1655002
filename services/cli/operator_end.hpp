#pragma once

#include <memory>

#include "services/bus/bus.hpp"
#include "services/cli/session_client.hpp"
#include "services/core/clock.hpp"
#include "services/core/lifetime.hpp"
#include "services/core/result.hpp"
#include "services/runtime/options.hpp"

namespace tonus::cli {

/// What a subcommand needs to take part in the system: signals, a clock, the bus and an operator's end of it.
class OperatorEnd {
 public:
  [[nodiscard]] static Result<std::unique_ptr<OperatorEnd>> join(const runtime::CommonOptions& options);

  [[nodiscard]] SessionClient& client() { return *client_; }
  [[nodiscard]] const Clock& clock() const { return clock_; }
  [[nodiscard]] bool is_interrupted() const { return stop_->is_requested(); }

  /// Waits until rig, scheduler, identification and archive are there and ready. `tick` is called a few times
  /// a second and ends the waiting by an error. kTimeout names what is missing.
  [[nodiscard]] Result<void> wait_for_roster(std::chrono::milliseconds limit,
                                             const std::function<Result<void>()>& tick = {});

 private:
  OperatorEnd() = default;

  std::shared_ptr<bus::Notifier> notifier_ = std::make_shared<bus::Notifier>();
  std::unique_ptr<StopSignal> stop_;
  SystemClock clock_;
  std::unique_ptr<bus::Bus> bus_;
  std::optional<SessionClient> client_;
};

}  // namespace tonus::cli
