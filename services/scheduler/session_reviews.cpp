// What operators say of trials and sessions: rejections by hand, and notes.

#include <algorithm>
#include <spdlog/fmt/fmt.h>

#include "services/contract/review.hpp"
#include "services/contract/subject.hpp"
#include "services/scheduler/session_machine.hpp"

namespace tonus::scheduler {
namespace {

/// Why a request about a trial is refused that the session does not have.
std::string unknown_trial(std::uint32_t begun) {
  if (begun == 0) return "trial: the session has begun none yet";
  return fmt::format("trial: not one of this session; expected one of the {} that it has begun", begun);
}

/// More notes than anybody writes; each is kept in memory and published to late joiners.
constexpr std::size_t kNotesMost = 1000;

}  // namespace

std::optional<std::uint32_t> SessionMachine::attempt_of(const Id& trial) const {
  const LedgerState& s = ledger_.state();
  for (std::uint32_t attempt = 1; attempt <= s.attempts; ++attempt) {
    if (trial_id(s.started.session_id, attempt) == trial) return attempt;
  }
  return std::nullopt;
}

std::string SessionMachine::why_not_reviewed(std::uint32_t attempt) const {
  const LedgerState& s = ledger_.state();
  if (s.counted_trials.contains(attempt)) return {};
  if (s.in_flight && s.in_flight->attempt() == attempt)
    return fmt::format("trial {} is not counted yet: it runs, or waits for its verdict", attempt);
  const auto known = std::ranges::find(s.reviews, attempt, &record::Reviewed::attempt);
  if (known == s.reviews.end()) return fmt::format("trial {} does not count: it was rejected", attempt);
  return fmt::format("trial {} was {} already{}: {}", attempt, contract::review_verb(known->reviewed_by),
                     known->reviewed_by.empty() ? "" : " by " + known->reviewed_by, known->reason);
}

void SessionMachine::review(const v1::SessionCommand& command) {
  const LedgerState& s = ledger_.state();
  const auto refuse = [&](const std::string& why) { answer(command.request_id(), false, why); };
  if (s.is_abort_wanted) return refuse("the session is being aborted");
  if (auto good = contract::check_operator_text("text", command.text()); !good)
    return refuse(good.error().message);
  if (auto good = contract::check_name("by", command.requested_by()); !good)
    return refuse(good.error().message);
  const auto attempt = attempt_of(command.trial_id());
  if (!attempt) return refuse(unknown_trial(s.attempts));
  if (const std::string why = why_not_reviewed(*attempt); !why.empty()) return refuse(why);

  const std::uint32_t index = s.counted_trials.at(*attempt);
  const bool is_recorded = s.protocol.kind == protocol::ProtocolKind::kRecording;
  const auto left = s.remaining[s.plan.trials[index].block].size();
  const record::Reviewed reviewed{
      *attempt,
      index,
      is_recorded ? record::Rejected::kSetAside  // it would give the same again
                  : static_cast<std::int32_t>(protocol::requeue_place(s.started.seed, *attempt, left)),
      command.text(),
      command.requested_by(),
      clock_.utc_ns()};
  decide(reviewed);
  publish(reviewed);
  message_ = fmt::format("trial {} rejected by hand: {}", *attempt, command.text());
  axes_due_.reset();
  look_due_.reset();
  complete_until_.reset();
  answer(command.request_id(), true,
         fmt::format("trial {} is left out{}", *attempt, is_recorded ? "" : " and runs again"));
  advance();
}

std::optional<std::int64_t> SessionMachine::rig_clock_ns() const {
  if (!rig_state_ || clock_.now() - rig_heard_at_ > patience_.rig_silence) return std::nullopt;
  // A simulated clock that runs at another pace is known as it was last reported.
  const auto since = rig_state_->is_realtime_paced() ? clock_.now() - rig_heard_at_ : Clock::Duration(0);
  return rig_state_->rig_clock_ns() + std::chrono::duration_cast<std::chrono::nanoseconds>(since).count();
}

void SessionMachine::take_note(const v1::SessionCommand& command) {
  const LedgerState& s = ledger_.state();
  const auto refuse = [&](const std::string& why) { answer(command.request_id(), false, why); };
  if (std::ranges::find(s.notes, command.request_id(), &record::Noted::note_id) != s.notes.end())
    return answer(command.request_id(), true, "noted");  // long ago; its answer is forgotten
  if (auto good = contract::check_note_kind(command.note_kind()); !good) return refuse(good.error().message);
  if (auto good = contract::check_operator_text("text", command.text()); !good)
    return refuse(good.error().message);
  if (auto good = contract::check_name("by", command.requested_by()); !good)
    return refuse(good.error().message);
  if (command.trial_id() != kNoId && !attempt_of(command.trial_id()))
    return refuse(unknown_trial(s.attempts));
  if (s.notes.size() >= kNotesMost)
    return refuse(fmt::format("the session has {} notes; expected at most {}", s.notes.size(), kNotesMost));

  const auto rig_clock = rig_clock_ns();
  const record::Noted noted{
      command.request_id(),  command.trial_id(),     command.note_kind(),
      command.text(),        command.requested_by(), clock_.utc_ns(),
      rig_clock.has_value(), rig_clock.value_or(0),  rig_clock ? rig_state_->epoch() : 0};
  decide(noted);
  publish(noted);
  answer(command.request_id(), true,
         rig_clock
             ? fmt::format("noted at {:.3f} s of the rig's clock", 1e-9 * static_cast<double>(*rig_clock))
             : "noted, without the rig's clock: the rig is not heard");
}

bool SessionMachine::uses_rejected_trial(const v1::Estimate& estimate) const {
  const auto& reviews = ledger_.state().reviews;
  return std::ranges::any_of(estimate.trials(), [&](const v1::TrialRange& trial) {
    return std::ranges::find(reviews, trial.attempt(), &record::Reviewed::attempt) != reviews.end();
  });
}

void SessionMachine::publish(const record::Reviewed& reviewed) {
  const LedgerState& s = ledger_.state();
  v1::TrialReview review;
  review.trial_id(trial_id(s.started.session_id, reviewed.attempt));
  review.session_id(s.started.session_id);
  review.attempt(reviewed.attempt);
  review.planned_index(reviewed.planned_index);
  review.posture_index(s.plan.blocks[s.plan.trials[reviewed.planned_index].block].posture_index);
  review.is_rejected(true);
  review.reason(reviewed.reason);
  review.reviewed_by(reviewed.reviewed_by);
  review.reviewed_ns(reviewed.reviewed_ns);
  effects_.messages.emplace_back(std::move(review));
}

void SessionMachine::publish(const record::Noted& noted) {
  v1::SessionNote note;
  note.note_id(noted.note_id);
  note.session_id(ledger_.state().started.session_id);
  note.trial_id(noted.trial_id);
  note.kind(noted.kind);
  note.text(noted.text);
  note.written_by(noted.written_by);
  note.written_ns(noted.written_ns);
  note.has_rig_clock(noted.has_rig_clock);
  note.rig_clock_ns(noted.rig_clock_ns);
  note.epoch(noted.epoch);
  effects_.messages.emplace_back(std::move(note));
}

}  // namespace tonus::scheduler
