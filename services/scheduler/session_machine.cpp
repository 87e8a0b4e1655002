// The course of a session: what comes next, and why it does not.

#include "services/scheduler/session_machine.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "services/protocol/bias_axes.hpp"
#include "services/scheduler/verdict_text.hpp"

namespace tonus::scheduler {

void SessionMachine::advance() {
  if (!is_active()) return;
  hold_.reset();
  if (ledger_.state().is_abort_wanted) return advance_abort();
  if (ledger_.state().in_flight) settle_in_flight();
  if (ledger_.state().in_flight) return watch_in_flight();
  hold_ = find_hold();
  if (!is_active()) return;
  if (hold_) {
    phase_ = hold_->phase;
    if (phase_ == v1::SESSION_PAUSED) answer_pending(v1::SESSION_PAUSE, true, "paused");
    return;
  }
  if (ledger_.state().attempts == 0) {
    phase_ = v1::SESSION_READY;
    publish_state();
  }
  phase_ = v1::SESSION_RUNNING;
  command_next();
}

void SessionMachine::advance_abort() {
  if (!ledger_.state().in_flight || outcome_) return end(v1::SESSION_ABORTED, "aborted by request");
  if (!abort_at_ || clock_.now() >= *abort_at_) {
    if (abort_repeats_ >= patience_.abort_repeats) {
      return end(v1::SESSION_ABORTED, "aborted by request; the rig has not confirmed that its trial ended");
    }
    send_abort();
  }
  hold_ = Hold{phase_, fmt::format("rig: to end trial {}", ledger_.state().attempts), Asks::kNobody};
}

void SessionMachine::settle_in_flight() {
  // Nothing is settled before the rig has said what happened: a verdict may arrive first.
  if (!outcome_) return;
  const v1::TrialProgram& program = *ledger_.state().in_flight;
  if (outcome_->end() == v1::TRIAL_REFUSED) {
    refusal_ = outcome_->detail();
    retry_at_ = clock_.now() + patience_.refusal;
    ++refusals_;
    message_ = fmt::format("trial {} refused by the rig: {}", program.attempt(), refusal_);
    return decide(record::Refused{program.attempt(), refusal_});
  }
  if (outcome_->end() != v1::TRIAL_COMPLETED) {
    if (outcome_->end() == v1::TRIAL_FAULTED) withdraw(outcome_->detail());
    const bool is_aborted = outcome_->end() == v1::TRIAL_ABORTED;
    reject(fmt::format("{}: {}", v1::end_name(outcome_->end()), outcome_->detail()), true);
    if (is_aborted) decide(record::Requested{kNoId, v1::SESSION_PAUSE});
    return;
  }
  if (verdict_ && !verdict_->is_valid()) {
    // What is wrong in a recording is so every time; what was lost on the way is worth another try.
    const bool is_recorded = ledger_.state().protocol.kind == protocol::ProtocolKind::kRecording;
    const bool is_new_loss =
        may_be_lost_on_the_way(*verdict_) && ledger_.state().runs[program.planned_index()] < 2;
    return reject(verdict_text(*verdict_), !is_recorded || is_new_loss);
  }
  if (!verdict_ || !receipt_) return;
  // Identification had samples that the archive never will: the trial would be in the estimate and not in
  // what is left.
  if (receipt_->missing_samples() > 0) {
    return reject(fmt::format("archive: {} of {} samples are missing for good", receipt_->missing_samples(),
                              receipt_->expected_samples()),
                  true);
  }
  refusals_ = 0;
  decide(record::Counted{program.attempt(), outcome_duration()});
}

void SessionMachine::reject(const std::string& reason, bool can_repeat) {
  const LedgerState& s = ledger_.state();
  const std::uint32_t attempt = s.in_flight->attempt();
  const auto& left = s.remaining[s.plan.trials[s.in_flight->planned_index()].block];
  record::Rejected rejected;
  rejected.attempt = attempt;
  rejected.place =
      can_repeat ? static_cast<std::int32_t>(protocol::requeue_place(s.started.seed, attempt, left.size()))
                 : record::Rejected::kSetAside;
  rejected.owes_receipt = !receipt_;
  rejected.duration = outcome_duration();
  rejected.reason = reason;
  rejected.is_reviewed = verdict_ && verdict_->is_valid();
  if (rejected.is_reviewed) rejected.reviewed_ns = clock_.utc_ns();
  refusals_ = 0;
  message_ = fmt::format("trial {} rejected: {}", attempt, reason);
  decide(rejected);
  if (rejected.is_reviewed) publish(ledger_.state().reviews.back());
}

void SessionMachine::watch_in_flight() {
  const bool is_to_be_sent = !outcome_ && clock_.now() >= resend_at_ && !runs_on_rig();
  if (!outcome_ && !runs_on_rig() && (!is_armed() || (is_to_be_sent && clock_.now() < moves_at_)))
    hold_ = hold_for_rig();
  if (!is_active()) return;
  if (hold_) {
    phase_ = ledger_.state().is_pause_wanted ? v1::SESSION_PAUSING : hold_->phase;
    return;
  }
  if (clock_.now() >= resend_at_) {
    if (!runs_on_rig()) ++resends_;
    repeat_in_flight();
  }
  const bool is_pausing = ledger_.state().is_pause_wanted;
  phase_ = is_pausing ? v1::SESSION_PAUSING : v1::SESSION_RUNNING;
  if (resends_ < patience_.resends) return;
  if (!is_pausing) phase_ = v1::SESSION_WAITING;
  hold_ = Hold{phase_, missing_of_in_flight(), Asks::kStuck};
}

std::string SessionMachine::missing_of_in_flight() const {
  const auto what = !outcome_ ? "rig: outcome" : !verdict_ ? "identification: verdict" : "archive: receipt";
  return fmt::format("{} of trial {}{}{}", what, ledger_.state().attempts,
                     roster_missing_.empty() ? "" : "; ", roster_missing_);
}

bool SessionMachine::runs_on_rig() const {
  return !outcome_ && roster_missing_.empty() && rig_state_ && rig_state_->mode() == v1::RIG_IN_TRIAL &&
         rig_state_->trial_id() == flight_id_;
}

std::optional<SessionMachine::Hold> SessionMachine::find_hold() {
  const LedgerState& s = ledger_.state();
  if (auto hold = hold_for_look()) {
    if (s.is_pause_wanted) return paused();
    return hold;
  }
  if (s.block == s.plan.blocks.size()) {
    phase_ = v1::SESSION_COMPLETING;
    publish_state();
    if (!complete_until_) complete_until_ = clock_.now() + patience_.receipt;
    const auto owed = s.owed_receipts.size();
    if (owed > 0 && clock_.now() < *complete_until_) {
      return Hold{phase_, fmt::format("archive: receipts of {} rejected trials", owed), Asks::kNobody};
    }
    end(v1::SESSION_COMPLETED,
        fmt::format("{} trials counted{}{}", s.counted, goals_missed(),
                    owed == 0 ? "" : fmt::format("; the archive has not confirmed {} rejected ones", owed)));
    return std::nullopt;
  }
  if (s.is_pause_wanted) return paused();
  if (auto hold = hold_for_rig(); hold || !is_active()) return hold;
  return hold_for_block();
}

SessionMachine::Hold SessionMachine::paused() const {
  return {v1::SESSION_PAUSED, is_held() ? clear_then_resume() : "operator: resume", Asks::kNobody};
}

SessionMachine::Hold SessionMachine::service_hold(const std::string& what) const {
  return {ledger_.state().attempts == 0 ? v1::SESSION_PREPARING : v1::SESSION_WAITING, what, Asks::kNobody};
}

std::string SessionMachine::clear_then_resume() const {
  return fmt::format("operator: the rig is held ({}); when it is safe, clear it, then resume",
                     rig_state_->held_because());
}

std::optional<SessionMachine::Hold> SessionMachine::hold_for_rig() {
  const LedgerState& s = ledger_.state();
  if (is_held()) {
    refusals_ = 0;  // a hold has its own reason, and nobody clears it unseen
    return Hold{v1::SESSION_WAITING, clear_then_resume(), Asks::kNobody};
  }
  if (!roster_missing_.empty()) return service_hold(roster_missing_);
  if (!facts_) return service_hold(facts_problem_);
  if (!s.bound) {
    if (auto good = protocol::check_against_rig(s.protocol, *facts_); !good) {
      end(v1::SESSION_FAILED, good.error().message);
      return std::nullopt;
    }
    decide(record::Bound{facts_->rig_id, {facts_->home.x(), facts_->home.y()}});
    publish_plan();
  } else if (s.bound->rig_id != facts_->rig_id) {
    return service_hold(fmt::format("rig: {} runs this session, {} is there", to_hex(s.bound->rig_id),
                                    to_hex(facts_->rig_id)));
  }
  if (refusals_ >= patience_.refusals) {
    return Hold{v1::SESSION_WAITING,
                fmt::format("operator: the rig refused a trial {} times ({}); resume tries again", refusals_,
                            refusal_),
                Asks::kRefusal};
  }
  if (refusals_ > 0 && clock_.now() < retry_at_) {
    return Hold{v1::SESSION_WAITING, fmt::format("rig: refused a trial ({}), which is tried again", refusal_),
                Asks::kNobody};
  }
  return hold_for_arming();
}

std::optional<SessionMachine::Hold> SessionMachine::hold_for_block() {
  const LedgerState& s = ledger_.state();
  const protocol::Block& block = s.plan.blocks[s.block];
  publish_cue(block);
  const v1::TrialProgram& first = s.plan.trials[block.order.front()].program;
  if (s.protocol.confirms_posture && !s.confirmed_postures.contains(block.posture_index)) {
    return Hold{
        v1::SESSION_WAITING,
        fmt::format(
            "operator: bring the subject's hand to posture '{}', ({:.3f}, {:.3f}) m from the shoulder, "
            "and resume",
            first.posture(), first.posture_m()[0], first.posture_m()[1]),
        Asks::kPosture};
  }
  if (s.rejections[s.block] >= static_cast<std::uint32_t>(s.protocol.rejection_limit)) {
    return Hold{
        v1::SESSION_WAITING,
        fmt::format(
            "operator: {} trials rejected in set {} at '{}', the limit is {} (last: {}); resume goes on",
            s.rejections[s.block], block.set_number, first.posture(), s.protocol.rejection_limit, message_),
        Asks::kLimit};
  }
  if (block.axis != protocol::BiasAxis::kNone && !s.axes.contains(block.posture_index))
    return hold_for_axes(block);
  return std::nullopt;
}

std::optional<SessionMachine::Hold> SessionMachine::hold_for_axes(const protocol::Block& block) {
  const LedgerState& s = ledger_.state();
  const std::string where =
      fmt::format("set one's stiffness at '{}'", s.plan.postures[block.posture_index].name());
  static const std::set<std::uint32_t> kNoAttempts;
  const auto found = s.set_one.find(block.posture_index);
  const auto& attempts = found == s.set_one.end() ? kNoAttempts : found->second;
  const v1::Estimate* best = nullptr;
  std::size_t left_out = 0;
  for (const auto& [id, estimate] : estimates_) {
    if (!protocol::is_of_set_one(estimate, s.started.session_id, block.posture_index,
                                 s.protocol.bias->method) ||
        uses_rejected_trial(estimate))
      continue;
    const std::size_t without = protocol::trials_left_out(estimate, attempts);
    if (best != nullptr && without >= left_out) continue;
    best = &estimate;
    left_out = without;
  }
  if (!axes_due_) axes_due_ = clock_.now() + patience_.estimate;
  if (best == nullptr || (left_out > 0 && clock_.now() < *axes_due_)) {
    return service_hold(fmt::format("identification: {}", where));
  }
  protocol::AxesFinding finding = protocol::axes_of_estimate(*best);
  if (finding.kind == protocol::AxesFinding::Kind::kSound && left_out > 0) {
    finding.kind = protocol::AxesFinding::Kind::kDoubtful;
    finding.reason = fmt::format("it was made without {} of its {} trials", left_out, attempts.size());
  }
  if (finding.kind == protocol::AxesFinding::Kind::kNone) {
    return Hold{v1::SESSION_WAITING,
                fmt::format("operator: {} gives no axes for the bias: {}", where, finding.reason),
                Asks::kAxesMissing};
  }
  if (finding.kind == protocol::AxesFinding::Kind::kDoubtful && !accepts_doubtful_axes_) {
    return Hold{v1::SESSION_WAITING,
                fmt::format("operator: {} gives doubtful axes for the bias: {}; resume takes them", where,
                            finding.reason),
                Asks::kAxes};
  }
  accepts_doubtful_axes_ = false;
  axes_due_.reset();
  const auto& axes = finding.axes;
  decide(record::AxesFixed{block.posture_index,
                           {axes.major.x(), axes.major.y()},
                           {axes.minor.x(), axes.minor.y()},
                           best->stiffness_N_per_m().value()});
  return std::nullopt;
}

void SessionMachine::command_next() {
  const LedgerState& s = ledger_.state();
  const std::uint32_t index = s.remaining[s.block].front();
  const protocol::Block& block = s.plan.blocks[s.block];
  const auto axes = s.axes.find(block.posture_index);
  auto program = protocol::commanded_program(
      s.protocol, s.plan, index, s.started.session_id, s.attempts + 1, s.started.seed, s.runs[index] > 0,
      axes == s.axes.end() ? std::nullopt : std::optional<protocol::BiasAxes>(axes->second));
  if (s.protocol.stop_when && program.kind() == v1::TRIAL_PERTURBATION) steer_next(block.condition, program);
  decide(record::Commanded{program});
  flight_id_ = trial_id(s.started.session_id, s.attempts);
  outcome_.reset();
  verdict_.reset();
  receipt_.reset();
  resends_ = 0;
  send_in_flight();
}

void SessionMachine::send_in_flight() {
  v1::TrialCommand command;
  command.trial_id(flight_id_);
  command.program(*ledger_.state().in_flight);
  effects_.messages.emplace_back(std::move(command));
  resend_at_ = clock_.now() + patience_.answer;
  if (!outcome_ && rig_state_ && rig_state_->is_realtime_paced()) {
    const std::chrono::duration<double> expected(protocol::expected_duration(*ledger_.state().in_flight));
    resend_at_ += std::chrono::duration_cast<Clock::Duration>(1.25 * expected);
  }
}

void SessionMachine::repeat_in_flight() {
  // To a rig that is not armed nothing is commanded; one that knows the outcome only tells it anew.
  if (!ledger_.state().is_abort_wanted && (is_armed() || outcome_)) send_in_flight();
}

double SessionMachine::outcome_duration() const {
  if (outcome_ && outcome_->sample_rate_Hz() > 0.0 &&
      outcome_->last_sequence() >= outcome_->first_sequence()) {
    return static_cast<double>(outcome_->last_sequence() - outcome_->first_sequence() + 1) /
           outcome_->sample_rate_Hz();
  }
  return protocol::expected_duration(*ledger_.state().in_flight);
}

void SessionMachine::end(v1::SessionPhase phase, const std::string& message) {
  phase_ = phase;
  hold_.reset();
  message_ = message;
  if (is_armed()) {
    v1::RigCommand disarm;
    disarm.rig_id(rig_state_->rig_id());
    disarm.request_id(new_id_());
    disarm.request(v1::RIG_DISARM);
    disarm.session_id(ledger_.state().started.session_id);
    disarm.requested_by("scheduler");
    effects_.messages.emplace_back(std::move(disarm));
    armed_epoch_.reset();
  }
  decide(record::Ended{phase, message});
  abort_at_.reset();
  complete_until_.reset();
  const std::string text = fmt::format("the session has {}: {}", phase_name(phase), message);
  answer_pending(v1::SESSION_PAUSE, false, text);
  answer_pending(v1::SESSION_RESUME, false, text);
  answer_pending(v1::SESSION_ABORT, phase == v1::SESSION_ABORTED, message);
}

}  // namespace tonus::scheduler
