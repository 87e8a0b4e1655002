#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/bus/bus.hpp"
#include "services/bus/typed.hpp"
#include "services/core/clock.hpp"
#include "services/core/id.hpp"
#include "services/runtime/health.hpp"

#include <idl/estimate.h>
#include <idl/rig.h>
#include <idl/session.h>
#include <idl/trial.h>

namespace tonus::cli {

/// An operator's end of the bus: sees services, session and results, and asks things of the scheduler.
/// One thread; update() takes what has arrived, the rest tells what is known.
class SessionClient {
 public:
  /// With `may_command` false requests are refused here: on a secured bus, one who may only read could not
  /// even create what they are written with.
  [[nodiscard]] static Result<SessionClient> create(bus::Bus& bus, const Clock& clock,
                                                    std::shared_ptr<bus::Notifier> notifier,
                                                    bool may_command = true);

  void update();

  /// Handles arrivals until `done` says so. kTimeout after `limit`; kUnavailable as soon as `interrupted`
  /// says so.
  [[nodiscard]] Result<void> wait_for(const std::function<bool()>& done, std::chrono::milliseconds limit,
                                      const std::function<bool()>& interrupted = {});

  /// Sends a request and waits for its reply, asking again every half second. The reply's message is the
  /// value; kInvalidArgument with it where the scheduler refused, kTimeout where nobody answered within
  /// `limit`.
  [[nodiscard]] Result<std::string> request(v1::SessionCommand command, std::chrono::milliseconds limit);
  /// As above, of the rig.
  [[nodiscard]] Result<std::string> request(v1::RigCommand command, std::chrono::milliseconds limit);

  [[nodiscard]] runtime::Roster& roster() { return roster_; }
  [[nodiscard]] const std::optional<v1::RigDescription>& rig() const { return rig_; }
  /// Newest state of the rig of that id.
  [[nodiscard]] const std::optional<v1::RigState>& rig_state(const Id& rig) const;
  [[nodiscard]] const std::optional<v1::SessionState>& state(const Id& session) const;

  /// State of the session that is going on; where there is none, of one that has ended.
  [[nodiscard]] const std::optional<v1::SessionState>& newest_state() const { return newest_state_; }

  /// Newest estimates of a session's conditions, in the order of posture, set and method.
  [[nodiscard]] std::vector<v1::Estimate> estimates(const Id& session) const;

  /// True when every trial that the session counts has its verdict, and every valid one but no rejected one
  /// stands behind some estimate: the last results have arrived.
  [[nodiscard]] bool has_estimated_every_valid_trial(const Id& session) const;

  /// Verdicts of a session that are not valid, operators' reviews included, in the order of attempts.
  [[nodiscard]] std::vector<v1::TrialVerdict> rejections(const Id& session) const;

 private:
  struct Endpoints {
    /// None where this end may not command.
    std::optional<bus::TypedWriter<v1::SessionCommand>> commands;
    bus::TypedReader<v1::SessionReply> replies;
    bus::TypedReader<v1::SessionState> states;
    bus::TypedReader<v1::Estimate> estimates;
    bus::TypedReader<v1::TrialVerdict> verdicts;
    bus::TypedReader<v1::TrialReview> reviews;
    bus::TypedReader<v1::RigDescription> descriptions;
    bus::TypedReader<v1::RigState> rig_states;
    std::optional<bus::TypedWriter<v1::RigCommand>> rig_commands;
    bus::TypedReader<v1::RigReply> rig_replies;
  };
  template <typename Command>
  [[nodiscard]] Result<std::string> ask(std::optional<bus::TypedWriter<Command>>& writer, Command command,
                                        std::chrono::milliseconds limit, const char* who);
  SessionClient(Endpoints endpoints, runtime::Roster roster, const Clock& clock,
                std::shared_ptr<bus::Notifier> notifier);
  /// With an operator's review.
  [[nodiscard]] v1::TrialVerdict standing(const v1::TrialVerdict& verdict) const;

  Endpoints endpoints_;
  runtime::Roster roster_;
  const Clock* clock_;
  std::shared_ptr<bus::Notifier> notifier_;

  std::optional<v1::RigDescription> rig_;
  std::map<Id, std::optional<v1::SessionState>> states_;
  std::optional<v1::SessionState> newest_state_;
  std::map<Id, v1::Estimate> estimates_;
  std::map<Id, v1::TrialVerdict> verdicts_;  // as published
  std::map<Id, v1::TrialReview> reviews_;
  std::map<Id, std::optional<v1::RigState>> rig_states_;
  struct Reply {
    bool is_done = false;
    std::string message;
  };
  std::map<Id, Reply> replies_;
};

}  // namespace tonus::cli
