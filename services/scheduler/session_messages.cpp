// What a session publishes: its plan, cue, state and replies.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "services/scheduler/session_machine.hpp"

namespace tonus::scheduler {
namespace {

/// In place of an instruction's index: the subject contracts.
constexpr std::uint32_t kContraction = UINT32_MAX;

}  // namespace

void SessionMachine::decide(Record record) {
  // A decision that does not fit the session is a fault in this program: better to end, with the journal as
  // it is and good for a restart, than to write it down.
  if (const auto good = ledger_.apply(record); !good) {
    std::fprintf(stderr, "scheduler: %s\n", good.error().message.c_str());
    std::abort();
  }
  effects_.records.push_back(std::move(record));
}

void SessionMachine::begin_session() {
  phase_ = v1::SESSION_PREPARING;
  hold_.reset();
  message_.clear();
  has_published_ = false;
  cued_.reset();
  estimates_.clear();
  axes_due_.reset();
  look_due_.reset();
  flight_id_ = kNoId;
  outcome_.reset();
  verdict_.reset();
  receipt_.reset();
  resends_ = 0;
  refusals_ = 0;
  accepts_doubtful_axes_ = false;
  abort_at_.reset();
  abort_repeats_ = 0;
  complete_until_.reset();
  publish_plan();
  for (const record::Reviewed& reviewed : ledger_.state().reviews) publish(reviewed);
  for (const record::Noted& noted : ledger_.state().notes) publish(noted);
}

void SessionMachine::publish_plan() {
  const LedgerState& s = ledger_.state();
  v1::SessionPlan plan;
  plan.session_id(s.started.session_id);
  if (s.bound) plan.rig_id(s.bound->rig_id);
  plan.subject(s.started.subject);
  plan.subject_facts(s.started.subject_facts);
  plan.operator_name(s.started.operator_name);
  plan.study(s.started.study);
  plan.is_pilot(s.started.is_pilot);
  plan.protocol_name(s.protocol.name);
  plan.protocol_toml(s.started.protocol_toml);
  plan.seed(s.started.seed);
  plan.planned_trials(static_cast<std::uint32_t>(s.plan.trials.size()));
  plan.postures(s.plan.postures);
  plan.started_at(s.started.started_at);
  plan.software_version(s.started.software_version);
  effects_.messages.emplace_back(std::move(plan));
}

void SessionMachine::publish_cue(const protocol::Block& block) {
  const LedgerState& s = ledger_.state();
  const v1::TrialProgram& first = s.plan.trials[block.order.front()].program;
  const bool is_contraction = first.kind() == v1::TRIAL_CONTRACTION;
  const std::pair condition{block.posture_index, is_contraction ? kContraction : block.instruction_index};
  if (cued_ == condition) return;
  cued_ = condition;
  v1::SessionCue cue;
  cue.session_id(s.started.session_id);
  cue.target_m(s.plan.postures[block.posture_index].position_m());
  cue.target_diameter_m(s.protocol.cue.target_diameter);
  if (is_contraction) {
    cue.instruction("Tense all muscles of the arm as hard as you can, and keep the hand in its place");
  } else if (s.protocol.kind == protocol::ProtocolKind::kRecording) {
    cue.instruction(first.instruction());
  } else {
    cue.instruction(s.protocol.instructions[block.instruction_index].text);
  }
  cue.shows_cursor(s.protocol.cue.shows_cursor);
  effects_.messages.emplace_back(std::move(cue));
}

v1::SessionState SessionMachine::described() const {
  const LedgerState& s = ledger_.state();
  v1::SessionState state;
  state.session_id(s.started.session_id);
  state.phase(phase_);
  if (hold_) state.waiting_for(hold_->waiting_for);
  state.message(message_);
  if (!s.ended && s.in_flight) {
    state.posture(s.in_flight->posture());
    state.trial_id(flight_id_);
  } else if (!s.ended && s.block < s.plan.blocks.size()) {
    state.posture(s.plan.postures[s.plan.blocks[s.block].posture_index].name());
  }
  state.attempts(s.attempts);
  state.counted(s.counted);
  state.rejected(s.rejected);
  state.planned(static_cast<std::uint32_t>(s.plan.trials.size()));
  const double pace = s.expected_settled > 0.0 ? s.experiment / s.expected_settled : 1.0;
  state.remaining_s(s.ended ? 0.0 : std::max(0.0, s.expected_remaining) * pace);
  state.experiment_s(s.experiment);
  describe_conditions(state);
  return state;
}

void SessionMachine::publish_state() {
  if (!ledger_.has_session()) return;
  v1::SessionState state = described();
  if (has_published_ && state == published_) return;
  has_published_ = true;
  published_ = state;
  effects_.messages.emplace_back(std::move(state));
}

std::string SessionMachine::where_it_stands() const {
  return hold_ && !hold_->waiting_for.empty()
             ? fmt::format("{}: waiting for {}", phase_name(phase_), hold_->waiting_for)
             : phase_name(phase_);
}

void SessionMachine::reply(const Id& session_id, const Id& request_id, bool is_done,
                           const std::string& message) {
  v1::SessionReply reply;
  reply.session_id(session_id);
  reply.request_id(request_id);
  reply.is_done(is_done);
  reply.message(message);
  replies_.emplace_back(std::move(reply));
}

Effects SessionMachine::finish() {
  publish_state();
  std::move(replies_.begin(), replies_.end(), std::back_inserter(effects_.messages));
  replies_.clear();
  return std::exchange(effects_, {});
}

}  // namespace tonus::scheduler
