// What a session hears of its peers, and of the passing of time.

#include <algorithm>
#include <utility>

#include "services/scheduler/session_machine.hpp"

namespace tonus::scheduler {

SessionMachine::SessionMachine(const Clock& clock, std::string software_version, Patience patience,
                               IdSource new_id)
    : clock_(clock),
      software_version_(std::move(software_version)),
      patience_(patience),
      new_id_(std::move(new_id)) {}

Result<Effects> SessionMachine::restore(const std::vector<Record>& records) {
  for (const Record& record : records) {
    if (auto good = ledger_.apply(record); !good) return good.error();
  }
  if (!ledger_.has_session()) return Effects{};
  begin_session();
  if (const auto& ended = ledger_.state().ended) {  // it may have died before it could say so
    phase_ = ended->phase;
    message_ = ended->message;
    return finish();
  }
  answer_pending(v1::SESSION_RESUME, false, "the scheduler was restarted; ask again");
  withdraw("the scheduler was restarted");
  if (ledger_.state().in_flight) {
    flight_id_ = trial_id(ledger_.state().started.session_id, ledger_.state().attempts);
    resend_at_ = clock_.now();  // once the rig is armed; what became of it the rig tells by itself
  }
  advance();
  return finish();
}

Effects SessionMachine::on_outcome(const v1::TrialOutcome& outcome) {
  if (is_active() && is_in_flight(outcome.trial_id())) {
    outcome_ = outcome;
    resend_at_ = clock_.now() + patience_.answer;
    advance();
  }
  return finish();
}

Effects SessionMachine::on_verdict(const v1::TrialVerdict& verdict) {
  if (is_active() && is_in_flight(verdict.trial_id())) {
    verdict_ = verdict;
    advance();
  }
  return finish();
}

Effects SessionMachine::on_receipt(const v1::ArchiveReceipt& receipt) {
  if (!is_active() || receipt.kind() != v1::RECEIPT_TRIAL) return finish();
  if (is_in_flight(receipt.subject_id())) {
    receipt_ = receipt;
    advance();
    return finish();
  }
  const auto& owed = ledger_.state().owed_receipts;
  const auto paid = std::find_if(owed.begin(), owed.end(), [&](std::uint32_t attempt) {
    return trial_id(ledger_.state().started.session_id, attempt) == receipt.subject_id();
  });
  if (paid != owed.end()) {
    decide(record::Receipted{*paid});
    advance();
  }
  return finish();
}

Effects SessionMachine::on_estimate(const v1::Estimate& estimate) {
  if (is_active() && estimate.session_id() == ledger_.state().started.session_id) {
    estimates_[estimate.estimate_id()] = estimate;
    advance();
  }
  return finish();
}

Effects SessionMachine::on_rig_description(const v1::RigDescription& description) {
  resumes_unattended_ = description.resumes_unattended() && description.moves_nothing_real();
  auto facts = protocol::facts_of(description);
  facts_.reset();
  if (facts) {
    facts_ = *facts;
  } else {
    facts_problem_ = facts.error().message;
  }
  advance();
  return finish();
}

Effects SessionMachine::on_rig_state(const v1::RigState& state) {
  rig_heard_at_ = clock_.now();
  note_rig_mode(state);
  advance();
  return finish();
}

Effects SessionMachine::on_roster(const std::string& missing) {
  const bool is_back = !roster_missing_.empty() && missing.empty();
  roster_missing_ = missing;
  if (is_back && is_active() && ledger_.state().in_flight) repeat_in_flight();
  advance();
  return finish();
}

Effects SessionMachine::on_tick() {
  advance();
  return finish();
}

std::optional<Clock::TimePoint> SessionMachine::next_deadline() const {
  std::optional<Clock::TimePoint> next;
  const auto consider = [&next](Clock::TimePoint time) { next = next ? std::min(*next, time) : time; };
  if (!is_active()) return next;
  if (!is_armed() && arm_again_at_) consider(*arm_again_at_);
  if (is_armed() && moves_at_ > clock_.now()) consider(moves_at_);
  if (abort_at_) consider(*abort_at_);
  if (ledger_.state().in_flight && !ledger_.state().is_abort_wanted) consider(resend_at_);
  if (refusals_ > 0 && refusals_ < patience_.refusals && retry_at_ > clock_.now()) consider(retry_at_);
  if (axes_due_ && *axes_due_ > clock_.now()) consider(*axes_due_);
  if (look_due_) {
    const Clock::TimePoint shown = *look_due_ - patience_.estimate + patience_.answer;
    consider(clock_.now() < shown ? shown : *look_due_);
  }
  if (complete_until_) consider(*complete_until_);
  return next;
}

}  // namespace tonus::scheduler
