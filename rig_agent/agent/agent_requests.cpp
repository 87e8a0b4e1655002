// What operators and schedulers ask of the rig, what holds it, and who frees it.

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <utility>

#include "rig_agent/agent/agent.hpp"
#include "rig_agent/agent/hold_reason.hpp"
#include "rig_agent/control/fault_text.hpp"
#include "services/runtime/drain.hpp"

namespace tonus::rig {
namespace {

constexpr std::chrono::milliseconds kUnattendedPeriod{500};
constexpr std::size_t kAnswersKept = 256;
/// Requests that may wait for the loop's answer; more are answered at once that they were not carried out.
constexpr std::size_t kMostPendingReplies = control::RigLoop::kCommandCapacity;
/// Stops are not held up by other requests: room of their own for their confirmations.
constexpr std::size_t kMostPendingStops = kMostPendingReplies + 256;

constexpr const char* kTooManyWait = "too many requests wait for an answer; ask again";

}  // namespace

bool Agent::has_too_many_pending() const { return pending_replies_.size() >= kMostPendingReplies; }

void Agent::take_rig_commands() {
  if (const std::string by = stops_.take(); !by.empty()) {
    spdlog::warn("stop by {}", by);
    latch("stop by " + by, true);
    advance_simulated_clock();
  }
  for (const auto& received : runtime::drain(endpoints_.rig_commands)) {
    if (received.value.rig_id() == options_.names.id) carry_out(received.value);
  }
}

void Agent::carry_out(const v1::RigCommand& command) {
  const auto is_same = [&command](const auto& reply) { return reply.request_id() == command.request_id(); };
  if (const auto known = std::find_if(answered_.begin(), answered_.end(), is_same);
      known != answered_.end()) {
    send_reply(*known);
    return;
  }
  if (std::any_of(pending_replies_.begin(), pending_replies_.end(), [&is_same](const PendingReply& pending) {
        return pending.reply && is_same(*pending.reply);
      }))
    return;  // its answer is still to come
  PendingReply pending;
  pending.request = ++last_request_;
  pending.reply.emplace();
  pending.reply->rig_id(options_.names.id);
  pending.reply->request_id(command.request_id());
  switch (command.request()) {
    case v1::RIG_EMERGENCY_STOP:
      stop(std::move(pending), command.requested_by());
      break;
    case v1::RIG_ABORT_TRIAL:
      post(control::CommandKind::kAbort, std::move(pending));
      break;
    case v1::RIG_CLEAR_FAULT:
      clear_fault(command, std::move(pending));
      break;
    case v1::RIG_ARM:
      arm(command, std::move(pending));
      break;
    case v1::RIG_DISARM:
      if (lease_.session() == command.session_id() && !running_) lease_.disarm();
      answer(pending, true, "done");
      break;
  }
}

// A stop has been given already, and waits only for its confirmation.
void Agent::stop(PendingReply pending, const std::string& requested_by) {
  loop_.emergency_stop();
  spdlog::warn("stop by {}", requested_by);
  latch("stop by " + requested_by, true);
  pending.is_emergency_stop = true;
  if (pending_replies_.size() < kMostPendingStops) {
    pending_replies_.push_back(std::move(pending));
  } else {
    answer(pending, false, "the stop was given; too many requests wait for its confirmation");
  }
  advance_simulated_clock();
}

void Agent::post(control::CommandKind kind, PendingReply pending) {
  control::Command order;
  order.request = pending.request;
  order.kind = kind;
  if (has_too_many_pending()) {
    answer(pending, false, kTooManyWait);
  } else if (!loop_.post(order)) {
    answer(pending, false, "the loop's queue of commands is full; ask again");
  } else {
    pending_replies_.push_back(std::move(pending));
    advance_simulated_clock();
  }
}

void Agent::clear_fault(const v1::RigCommand& command, PendingReply pending) {
  if (!latch_.is_held()) return answer(pending, true, "the rig is not held");
  if (command.hold_number() != latch_.number()) {
    return answer(pending, false,
                  fmt::format("hold_number: {} is not allowed; expected {}, the hold in force: {}",
                              command.hold_number(), latch_.number(), latch_.because()));
  }
  pending.clears_hold = latch_.number();
  spdlog::info("hold {} is to be cleared by {}", latch_.number(), command.requested_by());
  if (!is_being_cleared()) return post(control::CommandKind::kClearFaults, std::move(pending));
  // A second order could clear what has happened after the first: this one waits for its answer.
  if (has_too_many_pending()) return answer(pending, false, kTooManyWait);
  pending.request = 0;
  pending_replies_.push_back(std::move(pending));
}

bool Agent::is_being_cleared() const {
  return std::any_of(pending_replies_.begin(), pending_replies_.end(), [this](const PendingReply& pending) {
    return pending.clears_hold == latch_.number() && pending.request != 0;
  });
}

std::string Agent::why_not_armed(const v1::RigCommand& command) const {
  if (command.session_id() == kNoId) return "session_id: 0 is not allowed; expected a session's";
  if (command.epoch() != options_.epoch)
    return "the rig agent was restarted since: an operator has to resume the session";
  if (latch_.is_held()) return why_no_trial();
  if (running_) return fmt::format("trial {} is running", running_->command.program().attempt());
  const Id armed = lease_.session();
  if (armed != kNoId && armed != command.session_id())
    return fmt::format("the rig is armed for session {}", to_hex(armed));
  return {};
}

void Agent::arm(const v1::RigCommand& command, PendingReply pending) {
  if (const std::string why = why_not_armed(command); !why.empty()) return answer(pending, false, why);
  lease_.arm(command.session_id(), clock_.now());
  spdlog::info("armed for session {}", to_hex(command.session_id()));
  answer(pending, true, "armed");
}

void Agent::hold(const std::string& because, bool needs_operator) {
  latch(because, needs_operator);
  if (loop_.state().faults == 0) loop_.hold();
}

void Agent::latch(const std::string& because, bool needs_operator) {
  const std::string before = latch_.because();
  const auto held = latch_.hold(because, needs_operator);
  if (latch_.because() == before) return;
  if (!held) spdlog::error("the rig is held, and its latch is not on disk: {}", held.error().message);
  if (before.empty()) spdlog::warn("the rig is held: {}", latch_.because());
  lease_.disarm();
  state_due_ = clock_.now();
}

bool Agent::is_emergency_stopped() const {
  return (loop_.state().faults & control::bit(control::Fault::kEmergencyStop)) != 0;
}

// A fault of the loop becomes a hold before anything else is done about it.
void Agent::watch_hold() {
  const control::FaultBits faults = loop_.state().faults & ~control::bit(control::Fault::kHeld);
  const control::FaultBits news = faults & ~noted_faults_;
  if (news != 0) latch(phrase_of(HoldReason::kFault) + control::fault_text(news), is_emergency_stopped());
  noted_faults_ = faults;
  const bool may_clear = options_.resumes_unattended && latch_.is_held() && !latch_.needs_operator();
  if (!may_clear || running_ || is_being_cleared() || clock_.now() < unattended_due_) return;
  unattended_due_ = clock_.now() + kUnattendedPeriod;
  PendingReply pending;
  pending.request = ++last_request_;
  pending.clears_hold = latch_.number();
  post(control::CommandKind::kClearFaults, std::move(pending));
}

// A loop that does not come back from its driver sees neither stop nor fault: this thread acts for it.
void Agent::watch_cycles() {
  if (!options_.is_paced) return;
  const std::uint64_t cycle = loop_.state().cycle;
  if (cycle != cycle_ || cycle == 0) {
    cycle_ = cycle;
    cycle_at_ = clock_.now();
    stands_still_ = false;
    return;
  }
  if (clock_.now() - cycle_at_ <= options_.longest_cycle) return;
  (void)driver_.disable();
  if (stands_still_) return;
  stands_still_ = true;
  hold(phrase_of(HoldReason::kLoopStandsStill), false);
}

void Agent::watch_lease() {
  const auto heard = lease_.heard();
  if (!options_.is_paced || (heard && *heard != lease_heard_)) {
    loop_.keep_alive();
    if (heard) lease_heard_ = *heard;
  }
  const double limit = loop_.config().limits.command_timeout;
  if (!heard || running_ || limit <= 0.0 || !options_.is_paced) return;
  if (clock_.now() - *heard <= std::chrono::duration<double>(limit)) return;
  spdlog::warn("disarmed: the session's scheduler was not heard for {} s", limit);
  lease_.disarm();
}

void Agent::collect_replies() {
  std::erase_if(pending_replies_, [&](PendingReply& pending) {
    if (!pending.is_emergency_stop || !is_emergency_stopped()) return false;
    answer(pending, true, "stopped");
    return true;
  });
  control::CommandReply reply;
  while (loop_.next_reply(reply)) {
    const auto pending = std::find_if(pending_replies_.begin(), pending_replies_.end(),
                                      [&reply](const auto& entry) { return entry.request == reply.request; });
    if (pending == pending_replies_.end()) continue;
    const bool is_done = reply.result == control::CommandResult::kDone ||
                         reply.result == control::CommandResult::kNothingRunning;
    const std::string remains = "not cleared: " + control::fault_text(reply.remaining);
    if (pending->clears_hold != 0) {
      const std::uint32_t hold = pending->clears_hold;
      answer_clears(hold, is_done ? clear_latch(hold) : Result<void>(fail(ErrorCode::kUnavailable, remains)));
      continue;
    }
    if (pending->is_start) {
      if (!is_done && running_) {
        refuse(running_->command, "the loop did not start it: " + control::fault_text(loop_.state().faults));
        running_.reset();
      }
    } else {
      answer(*pending, is_done, is_done ? "done" : remains);
    }
    pending_replies_.erase(pending);
  }
}

// The loop is free; the latch follows, and where it cannot, the loop goes back.
Result<void> Agent::clear_latch(std::uint32_t hold) {
  noted_faults_ = 0;
  if (const auto cleared = latch_.clear(hold); !cleared) {
    if (latch_.is_held()) loop_.hold();
    return fail(cleared.error().code, "not cleared: " + cleared.error().message);
  }
  spdlog::info("hold {} is cleared", hold);
  state_due_ = clock_.now();
  return {};
}

// Everybody who asked for it.
void Agent::answer_clears(std::uint32_t hold, const Result<void>& cleared) {
  std::erase_if(pending_replies_, [&](PendingReply& pending) {
    if (pending.clears_hold != hold) return false;
    answer(pending, cleared.has_value(), cleared ? "cleared" : cleared.error().message);
    return true;
  });
}

void Agent::answer(PendingReply& pending, bool is_done, const std::string& message) {
  if (!pending.reply) return;
  pending.reply->is_done(is_done);
  pending.reply->message(message);
  pending.reply->rig_clock_ns(loop_.state().acquisition_ns);
  answered_.push_back(*pending.reply);
  if (answered_.size() > kAnswersKept) answered_.pop_front();
  send_reply(*pending.reply);
}

// Nobody who does not read holds up the rig: the request is asked again, and answered from memory.
void Agent::send_reply(const v1::RigReply& reply) {
  if (!endpoints_.replies.write(reply)) ++replies_dropped_;
}

v1::RigMode Agent::mode() const {
  if (latch_.is_held() || loop_.state().faults != 0) return v1::RIG_HELD;
  if (running_) return v1::RIG_IN_TRIAL;
  return lease_.session() != kNoId ? v1::RIG_ARMED : v1::RIG_FREE;
}

}  // namespace tonus::rig
