#include "rig_agent/agent/agent.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <utility>

#include "idl/topics.hpp"
#include "rig_agent/control/validation.hpp"
#include "services/runtime/drain.hpp"

namespace tonus::rig {
namespace {

constexpr std::chrono::milliseconds kStatePeriod{250};
constexpr std::chrono::milliseconds kPacedPoll{5};
constexpr std::chrono::seconds kLeftBehindPeriod{2};
/// Cycles of the simulated clock in one step: a fraction of a trial, so that commands are seen in between.
constexpr int kCyclesPerStep = 2000;
constexpr std::chrono::seconds kLogRepairPeriod{1};
constexpr std::chrono::milliseconds kUnattendedPeriod{500};
constexpr std::size_t kAnswersKept = 256;
/// Longest that one message may hold up the agent: its state follows again, its replies are asked for again.
constexpr std::chrono::milliseconds kPatience{20};
constexpr std::chrono::milliseconds kPatienceForReplies{1};
/// Requests that may wait for the loop's answer; more are answered at once that they were not carried out.
constexpr std::size_t kMostPendingReplies = control::RigLoop::kCommandCapacity;
/// Stops are not held up by other requests: room of their own for their confirmations.
constexpr std::size_t kMostPendingStops = kMostPendingReplies + 256;

template <typename T>
bus::Topic<T> with_patience(bus::Topic<T> topic, std::chrono::milliseconds patience) {
  topic.spec.qos.max_blocking = patience;
  return topic;
}

}  // namespace

Result<AgentEndpoints> AgentEndpoints::create(bus::Bus& bus, std::shared_ptr<bus::Notifier> notifier) {
  auto trial_commands = bus::TypedReader<v1::TrialCommand>::create(bus, topics::kTrialCommand, notifier);
  if (!trial_commands) return trial_commands.error();
  auto rig_commands = bus::TypedReader<v1::RigCommand>::create(bus, topics::kRigCommand, notifier);
  if (!rig_commands) return rig_commands.error();
  auto receipts = bus::TypedReader<v1::ArchiveReceipt>::create(bus, topics::kArchiveReceipt, notifier);
  if (!receipts) return receipts.error();
  auto resends = bus::TypedReader<v1::ArchiveResend>::create(bus, topics::kArchiveResend, notifier);
  if (!resends) return resends.error();
  auto outcomes = bus::TypedWriter<v1::TrialOutcome>::create(bus, topics::kTrialOutcome);
  if (!outcomes) return outcomes.error();
  auto replies =
      bus::TypedWriter<v1::RigReply>::create(bus, with_patience(topics::kRigReply, kPatienceForReplies));
  if (!replies) return replies.error();
  auto description = bus::TypedWriter<v1::RigDescription>::create(bus, topics::kRigDescription);
  if (!description) return description.error();
  auto state = bus::TypedWriter<v1::RigState>::create(bus, with_patience(topics::kRigState, kPatience));
  if (!state) return state.error();
  return AgentEndpoints{std::move(*trial_commands), std::move(*rig_commands), std::move(*receipts),
                        std::move(*resends),        std::move(*outcomes),     std::move(*replies),
                        std::move(*description),    std::move(*state)};
}

Agent::Agent(const AgentOptions& options, const AgentParts& parts, AgentEndpoints endpoints,
             const Clock& clock)
    : options_(options),
      loop_(parts.loop),
      driver_(parts.driver),
      recorded_(parts.recorded),
      publisher_(parts.publisher),
      spool_(parts.spool),
      log_(parts.log),
      latch_(parts.latch),
      lease_(parts.lease),
      stops_(parts.stops),
      endpoints_(std::move(endpoints)),
      clock_(clock) {}

void Agent::start(const v1::RigDescription& description) {
  if (latch_.is_held()) {
    spdlog::warn("the rig is held: {}", latch_.because());
    loop_.hold();
    if (!options_.is_paced) advance_simulated_clock(kCyclesPerStep);
  }
  if (auto sent = endpoints_.description.write(description); !sent) {
    spdlog::error("the rig's description is not published: {}", sent.error().message);
  }
  for (const auto& [epoch, through] : log_.received_through()) spool_.received(epoch, through);
  for (const auto& [id, outcome] : log_.outcomes()) publish_outcome(outcome);
  if (!log_.broken()) return;

  const BrokenTrial broken = *log_.broken();
  v1::TrialOutcome outcome;
  outcome.trial_id(broken.command.trial_id());
  outcome.program(broken.command.program());
  outcome.epoch(broken.epoch);
  outcome.end(v1::TRIAL_BROKEN_OFF);
  outcome.detail("the rig agent ended in the middle of the trial");
  outcome.first_sequence(broken.first_sequence);
  outcome.onset_sequence(broken.first_sequence);
  outcome.last_sequence(
      std::max(broken.first_sequence, spool_.last_sequence(broken.epoch, broken.first_sequence)));
  outcome.sample_rate_Hz(options_.names.sample_rate);
  spdlog::warn("trial {} was broken off by the end of the last run", broken.command.program().attempt());
  note_logged(log_.ended(outcome));
  publish_outcome(outcome);
}

Clock::TimePoint Agent::step() {
  watch_hold();
  watch_lease();
  watch_cycles();
  repair_log_if_due();
  take_receipts();
  take_resends();
  take_rig_commands();
  take_trial_commands();
  if (!options_.is_paced && running_) advance_simulated_clock(kCyclesPerStep);
  watch_hold();
  collect_replies();
  collect_samples();
  collect_results();
  resend_left_behind();
  publish_state_if_due();
  if (!options_.is_paced && running_) return clock_.now();  // more to simulate
  return options_.is_paced ? clock_.now() + kPacedPoll : state_due_;
}

std::string Agent::why_no_trial() const {
  const auto state = loop_.state();
  if (latch_.is_held()) return fmt::format("held: {}; when it is safe, clear it", latch_.because());
  if (state.faults != 0) return "fault: " + fault_text(state.faults);
  if (spool_.is_full()) return fmt::format("the spool is full: {} bytes without a receipt", spool_.bytes());
  if (!publisher_.spool_error().empty()) return "the spool cannot be written: " + publisher_.spool_error();
  if (!log_error_.empty()) return "the trial log cannot be written: " + log_error_;
  return {};
}

std::string Agent::why_not_ready() const {
  if (std::string why = why_no_trial(); !why.empty()) return why;
  return publisher_.has_readers() ? "" : "nobody reads the samples";
}

void Agent::note_logged(const Result<void>& logged) {
  if (logged) return;
  if (log_error_.empty()) {
    spdlog::error("the trial log cannot be written: {}", logged.error().message);
    log_repair_due_ = clock_.now() + kLogRepairPeriod;
  }
  log_error_ = logged.error().message;
}

void Agent::repair_log_if_due() {
  if (log_error_.empty() || clock_.now() < log_repair_due_) return;
  log_repair_due_ = clock_.now() + kLogRepairPeriod;
  if (auto written = log_.rewrite(); !written) return note_logged(written);
  spdlog::info("the trial log is whole again");
  log_error_.clear();
}

std::string Agent::activity() const {
  return running_ ? fmt::format("trial {}", running_->command.program().attempt()) : "idle";
}

void Agent::take_trial_commands() {
  for (const auto& received : runtime::drain(endpoints_.trial_commands)) {
    const auto& command = received.value;
    if (command.program().rig_id() != options_.names.id) continue;
    if (const auto* outcome = log_.find(command.trial_id())) {
      publish_outcome(*outcome);
    } else if (!running_) {
      begin(command);
    } else if (running_->command.trial_id() != command.trial_id()) {
      refuse(command, fmt::format("trial {} is running", running_->command.program().attempt()));
    }
  }
}

void Agent::begin(const v1::TrialCommand& command) {
  v1::TrialCommand prepared = command;
  control::Command start;
  start.request = ++last_request_;
  start.kind = control::CommandKind::kStartTrial;
  std::uint32_t segment = 0;
  if (recorded_ != nullptr) {
    auto found = recorded_->prepare(prepared.program());
    if (!found) return refuse(command, found.error().message);
    segment = *found;
  } else if (command.program().kind() != v1::TRIAL_PERTURBATION) {
    return refuse(command, "this rig has no recordings to play");
  }
  start.program = to_program(prepared.program(), ++last_number_);
  start.program.segment = segment;
  if (auto valid = control::validate(start.program, loop_.config().limits, recorded_ == nullptr); !valid) {
    return refuse(command, valid.error().message);
  }
  if (const std::string why = why_no_trial(); !why.empty()) return refuse(command, why);
  const auto armed_for = lease_.armed_for(clock_.now());
  if (!armed_for || lease_.session() != command.program().session_id())
    return refuse(command, "the rig is not armed for this session");
  if (options_.is_paced && *armed_for < options_.stillness) {
    return refuse(
        command,
        fmt::format("nothing moves in the first {} ms after the rig was armed",
                    std::chrono::duration_cast<std::chrono::milliseconds>(options_.stillness).count()));
  }
  if (pending_replies_.size() >= kMostPendingReplies)
    return refuse(command, "too many requests wait for the loop");
  if (auto logged = log_.begun(prepared, options_.epoch, loop_.state().next_sequence); !logged) {
    note_logged(logged);
    return refuse(command, why_no_trial());
  }
  if (!loop_.post(start)) return refuse(command, "the loop's queue of commands is full");
  publisher_.set_trial(prepared.program().session_id(), prepared.trial_id());
  running_ = RunningTrial{std::move(prepared), start.program.number};
  pending_replies_.push_back({.request = start.request, .reply = {}, .is_start = true});
}

void Agent::refuse(const v1::TrialCommand& command, const std::string& why) {
  spdlog::warn("trial {} is refused: {}", command.program().attempt(), why);
  v1::TrialOutcome outcome;
  outcome.trial_id(command.trial_id());
  outcome.program(command.program());
  outcome.epoch(options_.epoch);
  outcome.end(v1::TRIAL_REFUSED);
  outcome.detail(why);
  outcome.sample_rate_Hz(options_.names.sample_rate);
  note_logged(log_.ended(outcome));
  publish_outcome(outcome);
}

void Agent::take_rig_commands() {
  if (const std::string by = stops_.take(); !by.empty()) {
    spdlog::warn("stop by {}", by);
    latch("stop by " + by);
    if (!options_.is_paced) advance_simulated_clock(kCyclesPerStep);
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
        return !pending.is_start && is_same(pending.reply);
      }))
    return;  // its answer is still to come
  PendingReply pending;
  pending.request = ++last_request_;
  pending.reply.rig_id(options_.names.id);
  pending.reply.request_id(command.request_id());
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
  if (!options_.is_paced) advance_simulated_clock(kCyclesPerStep);
}

// A stop has been given already, and waits only for its confirmation.
void Agent::stop(PendingReply pending, const std::string& requested_by) {
  loop_.emergency_stop();
  spdlog::warn("stop by {}", requested_by);
  latch("stop by " + requested_by);
  pending.is_emergency_stop = true;
  if (pending_replies_.size() < kMostPendingStops) {
    pending_replies_.push_back(std::move(pending));
  } else {
    answer(pending, false, "the stop was given; too many requests wait for its confirmation");
  }
}

void Agent::post(control::CommandKind kind, PendingReply pending) {
  control::Command order;
  order.request = pending.request;
  order.kind = kind;
  if (pending_replies_.size() >= kMostPendingReplies) {
    answer(pending, false, "too many requests wait for an answer; ask again");
  } else if (!loop_.post(order)) {
    answer(pending, false, "the loop's queue of commands is full; ask again");
  } else {
    pending_replies_.push_back(std::move(pending));
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
  post(control::CommandKind::kClearFaults, std::move(pending));
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

void Agent::hold(const std::string& because) {
  latch(because);
  if (loop_.state().faults == 0) loop_.hold();
}

void Agent::latch(const std::string& because) {
  const bool was_held = latch_.is_held();
  if (auto held = latch_.hold(because); !held)
    spdlog::error("the rig is held, and its latch is not on disk: {}", held.error().message);
  if (!was_held) spdlog::warn("the rig is held: {}", latch_.because());
  lease_.disarm();
  state_due_ = clock_.now();
}

bool Agent::is_emergency_stopped() const {
  return (loop_.state().faults & control::bit(control::Fault::kEmergencyStop)) != 0;
}

// A fault of the loop becomes a hold before anything else is done about it.
void Agent::watch_hold() {
  const control::FaultBits faults = loop_.state().faults & ~control::bit(control::Fault::kHeld);
  if ((faults & ~noted_faults_) != 0) latch("fault: " + fault_text(faults & ~noted_faults_));
  noted_faults_ = faults;
  if (!options_.resumes_unattended || !latch_.is_held() || is_emergency_stopped() || running_) return;
  const bool is_stopped = latch_.because().find("stop by ") != std::string::npos;
  const bool is_doubled = latch_.because().find("another ") != std::string::npos;
  if (is_stopped || is_doubled || clock_.now() < unattended_due_) return;
  unattended_due_ = clock_.now() + kUnattendedPeriod;
  PendingReply pending;
  pending.request = ++last_request_;
  pending.is_start = true;  // nobody is answered
  pending.clears_hold = latch_.number();
  post(control::CommandKind::kClearFaults, std::move(pending));
  if (!options_.is_paced) advance_simulated_clock(kCyclesPerStep);
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
  hold("the loop stands still: the driver does not return");
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

void Agent::take_receipts() {
  for (const auto& received : runtime::drain(endpoints_.receipts)) {
    const auto& receipt = received.value;
    if (receipt.rig_id() != options_.names.id || receipt.kind() != v1::RECEIPT_STREAM) continue;
    spool_.received(receipt.epoch(), receipt.through_sequence());
    if (receipt.epoch() == options_.epoch)
      received_through_ = std::max(received_through_, receipt.through_sequence());
    note_logged(log_.received(receipt.epoch(), receipt.through_sequence()));
  }
}

void Agent::take_resends() {
  for (const auto& received : runtime::drain(endpoints_.resends)) {
    const auto& request = received.value;
    if (request.rig_id() != options_.names.id) continue;
    publisher_.resend({request.epoch(), request.first_sequence(), request.last_sequence()});
  }
}

void Agent::resend_left_behind() {
  if (clock_.now() < left_behind_due_) return;
  left_behind_due_ = clock_.now() + kLeftBehindPeriod;
  for (const auto& range : spool_.left_behind(options_.epoch)) publisher_.resend(range);
}

void Agent::advance_simulated_clock(int cycles) {
  const std::int64_t now = clock_.now().time_since_epoch().count();
  const bool was_running = running_.has_value();
  for (int i = 0; i < cycles && running_.has_value() == was_running; ++i) {
    loop_.keep_alive();
    if (!loop_.step(now) && !was_running) return;  // a recording between its segments
    if (loop_.samples_waiting() >= loop_.sample_capacity() / 2) collect_samples();
    if ((i & 63) == 0) collect_results();
  }
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
    if (is_done && pending->clears_hold != 0) {
      finish_clearing(*pending);
    } else if (pending->is_start) {
      if (!is_done && running_ && pending->clears_hold == 0) {
        refuse(running_->command, "the loop did not start it: " + fault_text(loop_.state().faults));
        running_.reset();
      }
    } else {
      answer(*pending, is_done, is_done ? "done" : "not cleared: " + fault_text(reply.remaining));
    }
    pending_replies_.erase(pending);
  }
}

// The loop is free; the latch follows, and where it cannot, the loop goes back.
void Agent::finish_clearing(PendingReply& pending) {
  noted_faults_ = 0;
  const auto cleared = latch_.clear(pending.clears_hold);
  if (cleared) {
    spdlog::info("hold {} is cleared", pending.clears_hold);
    state_due_ = clock_.now();
  } else {
    loop_.hold();
  }
  if (!pending.is_start)
    answer(pending, cleared.has_value(), cleared ? "cleared" : "not cleared: " + cleared.error().message);
}

void Agent::answer(PendingReply& pending, bool is_done, const std::string& message) {
  pending.reply.is_done(is_done);
  pending.reply.message(message);
  pending.reply.rig_clock_ns(loop_.state().acquisition_ns);
  answered_.push_back(pending.reply);
  if (answered_.size() > kAnswersKept) answered_.pop_front();
  send_reply(pending.reply);
}

// Nobody who does not read holds up the rig: the request is asked again, and answered from memory.
void Agent::send_reply(const v1::RigReply& reply) {
  if (!endpoints_.replies.write(reply)) ++replies_dropped_;
}

void Agent::collect_samples() {
  control::SampleRecord record;
  while (loop_.next_sample(record)) {
    const bool is_of_trial = running_ && record.trial == running_->number;
    publisher_.set_trial(is_of_trial ? running_->command.program().session_id() : kNoId,
                         is_of_trial ? running_->command.trial_id() : kNoId);
    publisher_.add(record);
  }
  publisher_.flush_if_due();
}

void Agent::collect_results() {
  control::TrialResult result;
  while (loop_.next_result(result)) {
    collect_samples();  // the trial's last sample is in the queue before its result
    publisher_.flush();
    if (!running_ || result.number != running_->number) continue;
    v1::TrialOutcome outcome;
    outcome.trial_id(running_->command.trial_id());
    outcome.program(running_->command.program());
    outcome.epoch(options_.epoch);
    outcome.end(to_wire(result.outcome));
    if (result.faults != 0) outcome.detail("fault: " + fault_text(result.faults));
    outcome.first_sequence(result.first_sequence);
    outcome.onset_sequence(result.has_onset ? result.onset_sequence : result.last_sequence);
    outcome.last_sequence(result.last_sequence);
    outcome.sample_rate_Hz(options_.names.sample_rate);
    note_logged(log_.ended(outcome));
    running_.reset();
    publish_outcome(outcome);
  }
}

void Agent::publish_outcome(const v1::TrialOutcome& outcome) {
  if (auto sent = endpoints_.outcomes.write(outcome); !sent) {
    spdlog::error("the outcome of trial {} is not published: {}", outcome.program().attempt(),
                  sent.error().message);
  }
}

v1::RigMode Agent::mode() const {
  if (latch_.is_held() || loop_.state().faults != 0) return v1::RIG_HELD;
  if (running_) return v1::RIG_IN_TRIAL;
  return lease_.session() != kNoId ? v1::RIG_ARMED : v1::RIG_FREE;
}

void Agent::publish_state_if_due() {
  const auto loop = loop_.state();
  v1::RigState state;
  state.rig_id(options_.names.id);
  state.epoch(options_.epoch);
  state.mode(mode());
  if (running_) state.trial_id(running_->command.trial_id());
  state.session_id(lease_.session());
  state.hold_number(latch_.number());
  state.held_because(latch_.because());
  state.next_sequence(loop.next_sequence);
  state.received_through(received_through_);
  state.spool_bytes(spool_.bytes());
  state.fault_bits(loop.faults);
  state.fault(fault_text(loop.faults));
  state.overruns(loop.missed_periods);
  state.dropped_samples(loop.samples_dropped);
  state.is_realtime_paced(options_.is_paced);
  state.rig_clock_ns(loop.acquisition_ns);
  // At full speed a change of mode is no news: the outcome says it. A fault is.
  const auto is_trial = [](v1::RigMode m) { return m == v1::RIG_IN_TRIAL || m == v1::RIG_ARMED; };
  const bool is_other_mode =
      published_state_ && published_state_->mode() != state.mode() &&
      (options_.is_paced || !is_trial(state.mode()) || !is_trial(published_state_->mode()));
  const bool is_news = !published_state_ || is_other_mode ||
                       published_state_->fault_bits() != state.fault_bits() ||
                       published_state_->hold_number() != state.hold_number() ||
                       published_state_->session_id() != state.session_id();
  if (!is_news && clock_.now() < state_due_) return;
  if (auto sent = endpoints_.state.write(state); !sent) {
    spdlog::warn("the rig's state is not published: {}", sent.error().message);
  }
  published_state_ = state;
  state_due_ = clock_.now() + kStatePeriod;
}

}  // namespace tonus::rig
