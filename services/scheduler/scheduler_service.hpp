#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/bus/typed.hpp"
#include "services/core/clock.hpp"
#include "services/core/id.hpp"
#include "services/core/id_source.hpp"
#include "services/runtime/health.hpp"
#include "services/scheduler/lease_sender.hpp"
#include "services/scheduler/session_folder.hpp"
#include "services/scheduler/session_machine.hpp"

#include <idl/archive.h>
#include <idl/estimate.h>
#include <idl/rig.h>
#include <idl/session.h>
#include <idl/trial.h>

namespace tonus::scheduler {

/// The ends of the service on the bus.
struct SchedulerEndpoints {
  bus::TypedReader<v1::SessionCommand> commands;
  bus::TypedReader<v1::TrialOutcome> outcomes;
  bus::TypedReader<v1::TrialVerdict> verdicts;
  bus::TypedReader<v1::ArchiveReceipt> receipts;
  bus::TypedReader<v1::Estimate> estimates;
  bus::TypedReader<v1::RigDescription> descriptions;
  bus::TypedReader<v1::RigState> rig_states;
  bus::TypedReader<v1::RigReply> rig_replies;
  bus::TypedWriter<v1::SessionPlan> plans;
  bus::TypedWriter<v1::SessionState> states;
  bus::TypedWriter<v1::SessionReply> replies;
  bus::TypedWriter<v1::SessionCue> cues;
  bus::TypedWriter<v1::TrialCommand> trial_commands;
  bus::TypedWriter<v1::RigCommand> rig_commands;
  bus::TypedWriter<v1::TrialReview> reviews;
  bus::TypedWriter<v1::SessionNote> notes;

  [[nodiscard]] static Result<SchedulerEndpoints> create(bus::Bus& bus,
                                                         std::shared_ptr<bus::Notifier> notifier);
};

/// Carries messages between the bus and a SessionMachine, and its decisions to the journal first. One thread
/// calls step(). A message that the bus does not take is offered again, in order, up to kOutboxMost of them.
class SchedulerService {
 public:
  static constexpr std::size_t kOutboxMost = 1000;

  /// `rig` is the name of the rig whose sessions this scheduler runs. Takes up the session that has not
  /// ended, if there is one; the errors of SessionFolder::reopen and SessionMachine::restore.
  [[nodiscard]] static Result<std::unique_ptr<SchedulerService>> create(
      SchedulerEndpoints endpoints, runtime::HealthReporter health, runtime::Roster roster,
      SessionFolder folder, std::unique_ptr<LeaseSender> lease, const std::string& rig, const Clock& clock,
      const IdSource& new_id = random_id);

  /// Handles all there is; returns when to call again at the latest. The error is that of the journal:
  /// without it nothing more may be commanded, and the program has to end.
  [[nodiscard]] Result<Clock::TimePoint> step();

 private:
  SchedulerService(SchedulerEndpoints endpoints, runtime::HealthReporter health, runtime::Roster roster,
                   SessionFolder folder, std::unique_ptr<LeaseSender> lease, const std::string& rig,
                   const Clock& clock, const IdSource& new_id);
  [[nodiscard]] Result<void> take_all();
  [[nodiscard]] std::string missing_services();
  [[nodiscard]] Result<void> take_command(const v1::SessionCommand& command);
  [[nodiscard]] Result<void> perform(Effects effects);
  [[nodiscard]] Result<void> record(const std::vector<Record>& records);
  void send(Message message);
  [[nodiscard]] bool offer(const Message& message);
  void flush();
  void report_health();

  SchedulerEndpoints endpoints_;
  runtime::HealthReporter health_;
  runtime::Roster roster_;
  SessionFolder folder_;
  std::unique_ptr<LeaseSender> lease_;
  const Id rig_id_;
  const Clock& clock_;
  SessionMachine machine_;
  std::optional<Journal> journal_;  // of the session that runs
  bool is_over_ = false;            // it has ended, and its journal is put away once everything is sent
  std::optional<std::string> missing_;
  bool is_plan_new_ = false;                      // the archive has not yet said whether it has room for it
  std::optional<std::uint64_t> archive_reports_;  // at the plan, or while something was missing
  std::deque<Message> outbox_;
  std::uint64_t dropped_ = 0;
};

}  // namespace tonus::scheduler
