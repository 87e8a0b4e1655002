// For whom the rig is armed: only after an operator's word, and never after a restart without a new one.

#include <algorithm>
#include <spdlog/fmt/fmt.h>

#include "services/scheduler/session_machine.hpp"

namespace tonus::scheduler {

/// An operator has said go. A rig that is armed already is armed anew, so that nothing moves in the first
/// second after a resume either; not while a trial runs.
void SessionMachine::authorise() {
  may_arm_ = true;
  withdrawn_.clear();
  if (ledger_.state().in_flight && is_armed()) return;
  armed_epoch_.reset();
  arm_again_at_.reset();
}

void SessionMachine::withdraw(const std::string& why) {
  may_arm_ = false;
  if (withdrawn_.empty()) withdrawn_ = why;
  armed_epoch_.reset();
  arm_again_at_.reset();
}

std::optional<v1::RigLease> SessionMachine::lease() const {
  if (!is_active() || !is_armed()) return std::nullopt;
  v1::RigLease lease;
  lease.rig_id(rig_state_->rig_id());
  lease.session_id(ledger_.state().started.session_id);
  lease.epoch(*armed_epoch_);
  return lease;
}

std::optional<SessionMachine::Hold> SessionMachine::hold_for_arming() {
  if (!rig_state_) return service_hold("rig: has not reported its state");
  if (!may_arm_ && !resumes_unattended_) {
    return Hold{v1::SESSION_WAITING, fmt::format("operator: resume ({})", withdrawn_), Asks::kArming};
  }
  if (!is_armed()) {
    request_arming();
    return service_hold(arm_refusal_.empty() ? "rig: to be armed" : "rig: is not armed: " + arm_refusal_);
  }
  if (clock_.now() < moves_at_)
    return service_hold("nothing: the rig is armed, and stays still for a second");
  return std::nullopt;
}

void SessionMachine::request_arming() {
  if (arm_again_at_ && clock_.now() < *arm_again_at_) return;
  arm_id_ = new_id_();  // never one that the rig has answered
  arm_again_at_ = clock_.now() + patience_.rig_reply;
  v1::RigCommand arm;
  arm.rig_id(rig_state_->rig_id());
  arm.request_id(arm_id_);
  arm.request(v1::RIG_ARM);
  arm.session_id(ledger_.state().started.session_id);
  arm.epoch(rig_state_->epoch());
  arm.requested_by("scheduler");
  effects_.messages.emplace_back(std::move(arm));
}

void SessionMachine::note_arming(const v1::RigReply& reply) {
  arm_id_ = kNoId;
  if (!reply.is_done() || !rig_state_) {
    arm_refusal_ = reply.message();
    arm_again_at_ = clock_.now() + patience_.refusal;
    return;
  }
  arm_refusal_.clear();
  arm_again_at_.reset();
  armed_epoch_ = rig_state_->epoch();
  armed_at_rig_ns_ = reply.rig_clock_ns();
  if (ledger_.state().in_flight && !outcome_) resend_at_ = clock_.now();  // it may have been lost
  moves_at_ = clock_.now();
  if (rig_state_->is_realtime_paced()) moves_at_ += patience_.stillness;
}

void SessionMachine::note_rig_mode(const v1::RigState& state) {
  const bool has_restarted = rig_state_ && rig_state_->epoch() != state.epoch();
  rig_state_ = state;
  if (has_restarted) {
    armed_at_rig_ns_ = 0;
    return withdraw("the rig agent was restarted");
  }
  if (state.mode() == v1::RIG_HELD) return withdraw(state.held_because());
  const bool is_stale = state.rig_clock_ns() <= armed_at_rig_ns_;  // it may have been sent before the reply
  if (state.mode() == v1::RIG_FREE && is_armed() && !is_stale)
    withdraw("the rig was disarmed: it did not hear this program in time");
}

}  // namespace tonus::scheduler
