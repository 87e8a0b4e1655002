#include "services/scheduler/scheduler_service.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <tuple>
#include <utility>

#include "idl/topics.hpp"
#include "services/core/name.hpp"
#include "services/runtime/drain.hpp"
#include "services/runtime/version.hpp"

namespace tonus::scheduler {
namespace {

constexpr std::chrono::milliseconds kOfferAgain{50};
constexpr std::chrono::milliseconds kSignOfLife{500};
constexpr const char* kPlanNotSeen = "archive: to say whether it has room for the plan";

}  // namespace

Result<SchedulerEndpoints> SchedulerEndpoints::create(bus::Bus& bus,
                                                      std::shared_ptr<bus::Notifier> notifier) {
  auto commands = bus::TypedReader<v1::SessionCommand>::create(bus, topics::kSessionCommand, notifier);
  if (!commands) return commands.error();
  auto outcomes = bus::TypedReader<v1::TrialOutcome>::create(bus, topics::kTrialOutcome, notifier);
  if (!outcomes) return outcomes.error();
  auto verdicts = bus::TypedReader<v1::TrialVerdict>::create(bus, topics::kTrialVerdict, notifier);
  if (!verdicts) return verdicts.error();
  auto receipts = bus::TypedReader<v1::ArchiveReceipt>::create(bus, topics::kArchiveReceipt, notifier);
  if (!receipts) return receipts.error();
  auto estimates = bus::TypedReader<v1::Estimate>::create(bus, topics::kEstimateCondition, notifier);
  if (!estimates) return estimates.error();
  auto descriptions = bus::TypedReader<v1::RigDescription>::create(bus, topics::kRigDescription, notifier);
  if (!descriptions) return descriptions.error();
  auto rig_states = bus::TypedReader<v1::RigState>::create(bus, topics::kRigState, notifier);
  if (!rig_states) return rig_states.error();
  auto rig_replies = bus::TypedReader<v1::RigReply>::create(bus, topics::kRigReply, notifier);
  if (!rig_replies) return rig_replies.error();
  auto plans = bus::TypedWriter<v1::SessionPlan>::create(bus, topics::kSessionPlan);
  if (!plans) return plans.error();
  auto states = bus::TypedWriter<v1::SessionState>::create(bus, topics::kSessionState);
  if (!states) return states.error();
  auto replies = bus::TypedWriter<v1::SessionReply>::create(bus, topics::kSessionReply);
  if (!replies) return replies.error();
  auto cues = bus::TypedWriter<v1::SessionCue>::create(bus, topics::kSessionCue);
  if (!cues) return cues.error();
  auto trial_commands = bus::TypedWriter<v1::TrialCommand>::create(bus, topics::kTrialCommand);
  if (!trial_commands) return trial_commands.error();
  auto rig_commands = bus::TypedWriter<v1::RigCommand>::create(bus, topics::kRigCommand);
  if (!rig_commands) return rig_commands.error();
  TONUS_TRY_ASSIGN(auto reviews, bus::TypedWriter<v1::TrialReview>::create(bus, topics::kTrialReview));
  TONUS_TRY_ASSIGN(auto notes, bus::TypedWriter<v1::SessionNote>::create(bus, topics::kSessionNote));
  return SchedulerEndpoints{
      std::move(*commands),       std::move(*outcomes),     std::move(*verdicts),   std::move(*receipts),
      std::move(*estimates),      std::move(*descriptions), std::move(*rig_states), std::move(*rig_replies),
      std::move(*plans),          std::move(*states),       std::move(*replies),    std::move(*cues),
      std::move(*trial_commands), std::move(*rig_commands), std::move(reviews),     std::move(notes)};
}

Result<std::unique_ptr<SchedulerService>> SchedulerService::create(
    SchedulerEndpoints endpoints, runtime::HealthReporter health, runtime::Roster roster,
    SessionFolder folder, std::unique_ptr<LeaseSender> lease, const std::string& rig, const Clock& clock,
    const IdSource& new_id) {
  auto lasting = folder.reopen();
  if (!lasting) return lasting.error();
  std::unique_ptr<SchedulerService> service(new SchedulerService(std::move(endpoints), std::move(health),
                                                                 std::move(roster), std::move(folder),
                                                                 std::move(lease), rig, clock, new_id));
  if (!*lasting) return service;
  Journal::Opened& opened = **lasting;
  auto effects = service->machine_.restore(opened.records);
  if (!effects) return effects.error();
  spdlog::info("session {} goes on after {} attempts, {} trials counted; {} torn bytes cut from its journal",
               to_hex(service->machine_.ledger().state().started.session_id),
               service->machine_.ledger().state().attempts, service->machine_.ledger().state().counted,
               opened.cut_bytes);
  service->journal_ = std::move(opened.journal);
  service->is_over_ = !service->machine_.is_active();
  if (auto good = service->perform(std::move(*effects)); !good) return good.error();
  return service;
}

SchedulerService::SchedulerService(SchedulerEndpoints endpoints, runtime::HealthReporter health,
                                   runtime::Roster roster, SessionFolder folder,
                                   std::unique_ptr<LeaseSender> lease, const std::string& rig,
                                   const Clock& clock, const IdSource& new_id)
    : endpoints_(std::move(endpoints)),
      health_(std::move(health)),
      roster_(std::move(roster)),
      folder_(std::move(folder)),
      lease_(std::move(lease)),
      rig_id_(rig_id(rig)),
      clock_(clock),
      machine_(clock, runtime::kVersion, {}, new_id) {}

Result<Clock::TimePoint> SchedulerService::step() {
  flush();
  if (auto good = perform({}); !good) return good.error();  // a session may be over now
  if (auto good = take_all(); !good) return good.error();
  if (const auto due = machine_.next_deadline(); due && clock_.now() >= *due) {
    if (auto good = perform(machine_.on_tick()); !good) return good.error();
  }
  lease_->set(machine_.lease());
  report_health();
  Clock::TimePoint next = health_.publish_if_due();
  TONUS_TRY(health_.check_alone());
  if (const auto due = machine_.next_deadline()) next = std::min(next, *due);
  if (!outbox_.empty()) next = std::min(next, clock_.now() + kOfferAgain);
  return std::min(next, clock_.now() + kSignOfLife);
}

Result<void> SchedulerService::take_all() {
  Result<void> good;
  // Each input's effects are performed before the next is taken.
  const auto each = [&](auto& reader, auto&& handle) {
    for (const auto& received : runtime::drain(reader)) {
      if (good) good = handle(received.value);
    }
  };
  roster_.update();
  if (auto missing = missing_services(); missing_ != missing) {
    missing_ = missing;
    good = perform(machine_.on_roster(missing));
  }
  each(endpoints_.descriptions, [this](const auto& description) -> Result<void> {
    return description.rig_id() == rig_id_ ? perform(machine_.on_rig_description(description))
                                           : Result<void>();
  });
  each(endpoints_.rig_states, [this](const auto& state) -> Result<void> {
    return state.rig_id() == rig_id_ ? perform(machine_.on_rig_state(state)) : Result<void>();
  });
  each(endpoints_.rig_replies, [this](const auto& reply) { return perform(machine_.on_rig_reply(reply)); });
  each(endpoints_.commands, [this](const auto& command) { return take_command(command); });
  each(endpoints_.estimates,
       [this](const auto& estimate) { return perform(machine_.on_estimate(estimate)); });
  each(endpoints_.outcomes, [this](const auto& outcome) { return perform(machine_.on_outcome(outcome)); });
  each(endpoints_.verdicts, [this](const auto& verdict) { return perform(machine_.on_verdict(verdict)); });
  each(endpoints_.receipts, [this](const auto& receipt) { return perform(machine_.on_receipt(receipt)); });
  return good;
}

std::string SchedulerService::missing_services() {
  if (std::string doubled = health_.other(); !doubled.empty()) return doubled;
  auto missing = roster_.missing({v1::ROLE_RIG, v1::ROLE_IDENTIFICATION, v1::ROLE_ARCHIVE});
  if (!is_plan_new_) return missing;
  // The archive says whether it has room in its first report after the plan; one that refuses, in a later
  // one.
  const auto reports = roster_.reports(v1::ROLE_ARCHIVE);
  if (!missing.empty() || !archive_reports_) archive_reports_ = reports;
  if (missing.empty() && archive_reports_ == reports) return kPlanNotSeen;
  is_plan_new_ = !missing.empty();
  return missing;
}

Result<void> SchedulerService::take_command(const v1::SessionCommand& command) {
  if (command.request() == v1::SESSION_START && !machine_.is_active()) {
    is_plan_new_ = true;
    archive_reports_.reset();
    missing_ = missing_services();
    if (auto good = perform(machine_.on_roster(*missing_)); !good) return good;
  }
  const bool is_other = !machine_.ledger().has_session() ||
                        command.session_id() != machine_.ledger().state().started.session_id;
  if (command.request() != v1::SESSION_START || !is_other || !folder_.knows(command.session_id())) {
    return perform(machine_.on_command(command));
  }
  v1::SessionReply reply;
  reply.session_id(command.session_id());
  reply.request_id(command.request_id());
  reply.is_done(false);
  reply.message(
      fmt::format("session {} has been: a new session needs a new id", to_hex(command.session_id())));
  send(std::move(reply));
  return {};
}

Result<void> SchedulerService::perform(Effects effects) {
  for (Message& message : effects.urgent) send(std::move(message));
  if (auto good = record(effects.records); !good) {
    health_.set_state(false, good.error().message);
    (void)health_.publish_if_due();
    return good;
  }
  for (Message& message : effects.messages) send(std::move(message));
  if (!is_over_ || !outbox_.empty()) return {};
  is_over_ = false;
  journal_.reset();
  return folder_.finish(machine_.ledger().state().started.session_id);
}

Result<void> SchedulerService::record(const std::vector<Record>& records) {
  if (records.empty()) return {};
  if (const auto* started = std::get_if<record::Started>(&records.front())) {
    auto journal = folder_.begin(started->session_id);
    if (!journal) return journal.error();
    journal_ = std::move(*journal);
    spdlog::info("session {} of subject '{}' starts, seed {}", to_hex(started->session_id), started->subject,
                 started->seed);
  }
  if (auto good = journal_->append(records); !good) return good;
  for (const Record& entry : records) {
    if (const auto* rejected = std::get_if<record::Rejected>(&entry)) {
      spdlog::info("trial {} rejected: {}", rejected->attempt, rejected->reason);
    } else if (const auto* refused = std::get_if<record::Refused>(&entry)) {
      spdlog::warn("trial {} refused by the rig: {}", refused->attempt, refused->reason);
    } else if (const auto* reviewed = std::get_if<record::Reviewed>(&entry)) {
      spdlog::info("trial {} rejected by hand by {}: {}", reviewed->attempt, reviewed->reviewed_by,
                   reviewed->reason);
    } else if (const auto* ended = std::get_if<record::Ended>(&entry)) {
      spdlog::info("session {}: {}", phase_name(ended->phase), ended->message);
      is_over_ = true;
    }
  }
  return {};
}

void SchedulerService::send(Message message) {
  if (outbox_.empty() && offer(message)) return;
  if (outbox_.size() < kOutboxMost) {
    outbox_.push_back(std::move(message));
  } else {
    ++dropped_;  // shown in the health; a command is sent again by its own patience
  }
}

bool SchedulerService::offer(const Message& message) {
  const auto write = [this](const auto& value) -> Result<void> {
    using T = std::decay_t<decltype(value)>;
    if constexpr (std::is_same_v<T, v1::SessionPlan>) return endpoints_.plans.write(value);
    if constexpr (std::is_same_v<T, v1::SessionState>) return endpoints_.states.write(value);
    if constexpr (std::is_same_v<T, v1::SessionReply>) return endpoints_.replies.write(value);
    if constexpr (std::is_same_v<T, v1::SessionCue>) return endpoints_.cues.write(value);
    if constexpr (std::is_same_v<T, v1::TrialCommand>) return endpoints_.trial_commands.write(value);
    if constexpr (std::is_same_v<T, v1::RigCommand>) return endpoints_.rig_commands.write(value);
    if constexpr (std::is_same_v<T, v1::TrialReview>) return endpoints_.reviews.write(value);
    if constexpr (std::is_same_v<T, v1::SessionNote>) return endpoints_.notes.write(value);
  };
  const auto sent = std::visit(write, message);
  if (sent || sent.error().code == ErrorCode::kTimeout) return sent.has_value();
  spdlog::error("a message cannot be sent and is left out: {}", sent.error().message);
  ++dropped_;
  return true;
}

void SchedulerService::flush() {
  while (!outbox_.empty() && offer(outbox_.front())) outbox_.pop_front();
}

void SchedulerService::report_health() {
  health_.set_load(0.0, static_cast<std::uint32_t>(outbox_.size()), dropped_);
  health_.set_state(true, machine_.is_active()
                              ? fmt::format("session {}", phase_name(machine_.state().phase()))
                              : std::string("no session"));
}

}  // namespace tonus::scheduler
