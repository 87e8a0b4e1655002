#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>

#include "services/bus/bus.hpp"
#include "services/cli/session_client.hpp"
#include "services/core/clock.hpp"
#include "services/core/lifetime.hpp"
#include "services/core/result.hpp"
#include "services/runtime/options.hpp"

namespace tonus::cli {

/// How long a command waits until the services are there and ready.
constexpr std::chrono::seconds kRosterLimit{30};

/// A subcommand's place in the system: signals, a clock, the bus and an operator's client on it.
class OperatorConnection {
 public:
  [[nodiscard]] static Result<std::unique_ptr<OperatorConnection>> join(
      const runtime::CommonOptions& options);

  [[nodiscard]] SessionClient& client() { return *client_; }
  [[nodiscard]] const Clock& clock() const { return clock_; }
  [[nodiscard]] bool is_interrupted() const { return stop_->is_requested(); }
  /// How often Ctrl-C was pressed.
  [[nodiscard]] int interruptions() const { return stop_->requests(); }

  /// Why the rig is held, with what to type; empty: it is not, or is not there.
  [[nodiscard]] std::string held() const;

  /// Waits for kRosterLimit until rig, scheduler, identification and archive are there and ready. `tick` is
  /// called a few times a second; its error ends the wait. kUnavailable as soon as the rig says that it is
  /// held; kTimeout names what is missing.
  [[nodiscard]] Result<void> wait_for_roster(const std::function<Result<void>()>& tick = {});

 private:
  OperatorConnection() = default;
  [[nodiscard]] bool is_complete_but_for_the_hold();

  std::shared_ptr<bus::Notifier> notifier_ = std::make_shared<bus::Notifier>();
  std::unique_ptr<StopSignal> stop_;
  SystemClock clock_;
  std::unique_ptr<bus::Bus> bus_;
  std::optional<SessionClient> client_;
  std::string rig_;
};

}  // namespace tonus::cli
