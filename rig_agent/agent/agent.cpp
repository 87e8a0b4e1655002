#include "rig_agent/agent/agent.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <utility>

#include "idl/topics.hpp"
#include "rig_agent/control/fault_text.hpp"
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
/// Longest that one message may hold up the agent: its state follows again, its replies are asked for again.
constexpr std::chrono::milliseconds kPatience{20};
constexpr std::chrono::milliseconds kPatienceForReplies{1};

template <typename T>
bus::Topic<T> with_patience(bus::Topic<T> topic, std::chrono::milliseconds patience) {
  topic.spec.qos.max_blocking = patience;
  return topic;
}

}  // namespace

Result<AgentEndpoints> AgentEndpoints::create(bus::Bus& bus, const std::shared_ptr<bus::Notifier>& notifier) {
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
      clock_(clock),
      auxiliary_(parts.loop.auxiliary_values()) {}

v1::TrialOutcome Agent::outcome_of(const v1::TrialCommand& command, std::uint64_t epoch,
                                   v1::TrialEnd end) const {
  v1::TrialOutcome outcome;
  outcome.trial_id(command.trial_id());
  outcome.program(command.program());
  outcome.epoch(epoch);
  outcome.end(end);
  outcome.sample_rate_Hz(options_.names.sample_rate);
  return outcome;
}

void Agent::start(const v1::RigDescription& description) {
  if (latch_.is_held()) {
    spdlog::warn("the rig is held: {}", latch_.because());
    loop_.hold();
    advance_simulated_clock();
  }
  if (auto sent = endpoints_.description.write(description); !sent) {
    spdlog::error("the rig's description is not published: {}", sent.error().message);
  }
  for (const auto& [epoch, through] : log_.received_through()) (void)spool_.received(epoch, 0, through);
  for (const auto& [id, outcome] : log_.outcomes()) publish_outcome(outcome);
  if (!log_.broken()) return;

  report_broken(*log_.broken());
}

// Where no sample of the trial was kept, nothing shows that it ran.
void Agent::report_broken(const BrokenTrial& broken) {
  const auto last = spool_.last_sequence(broken.epoch);
  if (!last || *last < broken.first_sequence)
    return refuse(broken.command, "the rig agent ended before the trial's first sample was kept");
  v1::TrialOutcome outcome = outcome_of(broken.command, broken.epoch, v1::TRIAL_BROKEN_OFF);
  outcome.detail("the rig agent ended in the middle of the trial");
  outcome.first_sequence(broken.first_sequence);
  outcome.onset_sequence(broken.first_sequence);
  outcome.last_sequence(*last);
  spdlog::warn("trial {} was broken off by the end of the last run", broken.command.program().attempt());
  end_trial(outcome);
}

// An outcome that was published before it was on disk could change when the agent dies.
void Agent::end_trial(const v1::TrialOutcome& outcome) {
  const auto logged = log_.ended(outcome);
  note_logged(logged);
  if (!logged) {
    unlogged_.insert(outcome.trial_id());
    spdlog::error("the outcome of trial {} is held back until the trial log can be written",
                  outcome.program().attempt());
  } else {
    publish_outcome(outcome);
  }
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
  if (running_) advance_simulated_clock();
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
  if (state.faults != 0) return "fault: " + control::fault_text(state.faults);
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
  for (const Id& trial : std::exchange(unlogged_, {})) {
    if (const auto* outcome = log_.find(trial)) publish_outcome(*outcome);
  }
}

std::string Agent::activity() const {
  return running_ ? fmt::format("trial {}", running_->command.program().attempt()) : "idle";
}

void Agent::take_trial_commands() {
  for (const auto& received : runtime::drain(endpoints_.trial_commands)) {
    const auto& command = received.value;
    if (command.program().rig_id() != options_.names.id) continue;
    if (const auto* outcome = log_.find(command.trial_id())) {
      if (!unlogged_.contains(command.trial_id())) publish_outcome(*outcome);
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
  } else if (command.program().kind() == v1::TRIAL_RECORDING) {
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
  if (has_too_many_pending()) return refuse(command, "too many requests wait for the loop");
  if (auto logged = log_.begun(prepared, options_.epoch, loop_.state().next_sequence); !logged) {
    note_logged(logged);
    return refuse(command, why_no_trial());
  }
  if (!loop_.post(start)) return refuse(command, "the loop's queue of commands is full");
  publisher_.set_trial(prepared.program().session_id(), prepared.trial_id());
  running_ = RunningTrial{std::move(prepared), start.program.number};
  pending_replies_.push_back({.request = start.request, .is_start = true});
}

void Agent::refuse(const v1::TrialCommand& command, const std::string& why) {
  spdlog::warn("trial {} is refused: {}", command.program().attempt(), why);
  v1::TrialOutcome outcome = outcome_of(command, options_.epoch, v1::TRIAL_REFUSED);
  outcome.detail(why);
  note_logged(log_.ended(outcome));
  publish_outcome(outcome);
}

void Agent::take_receipts() {
  for (const auto& received : runtime::drain(endpoints_.receipts)) {
    const auto& receipt = received.value;
    if (receipt.rig_id() != options_.names.id || receipt.kind() != v1::RECEIPT_STREAM) continue;
    // It speaks of `expected_samples` samples, those before `through_sequence`.
    const std::uint64_t through = receipt.through_sequence();
    const std::uint64_t first = through - std::min(through, receipt.expected_samples());
    const bool says_nothing = receipt.epoch() == options_.epoch && through == 0;
    if (!says_nothing && !spool_.received(receipt.epoch(), first, through)) {
      // Of earlier runs the archive may repeat receipts for what is forgotten here.
      if (receipt.epoch() == options_.epoch && receipts_refused_++ == 0)
        spdlog::warn(
            "a receipt for samples from {} to below {} is refused: not all of them are spooled, or "
            "earlier ones have none; further ones are refused without a line",
            first, through);
      continue;
    }
    if (receipt.epoch() == options_.epoch) received_through_ = std::max(received_through_, through);
    note_logged(log_.received(receipt.epoch(), through));
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

void Agent::advance_simulated_clock() {
  if (options_.is_paced) return;
  const std::int64_t now = clock_.now().time_since_epoch().count();
  const bool was_running = running_.has_value();
  for (int i = 0; i < kCyclesPerStep && running_.has_value() == was_running; ++i) {
    loop_.keep_alive();
    if (!loop_.step(now) && !was_running) return;  // a recording between its segments
    if (loop_.samples_waiting() >= loop_.sample_capacity() / 2) collect_samples();
    if ((i & 63) == 0) collect_results();
  }
}

void Agent::collect_samples() {
  control::SampleRecord record;
  while (loop_.next_sample(record, auxiliary_)) {
    const bool is_of_trial = running_ && record.trial == running_->number;
    publisher_.set_trial(is_of_trial ? running_->command.program().session_id() : kNoId,
                         is_of_trial ? running_->command.trial_id() : kNoId);
    publisher_.add(record, auxiliary_);
  }
  publisher_.flush_if_due();
}

void Agent::collect_results() {
  control::TrialResult result;
  while (loop_.next_result(result)) {
    collect_samples();  // the trial's last sample is in the queue before its result
    publisher_.flush();
    if (!running_ || result.number != running_->number) continue;
    v1::TrialOutcome outcome = outcome_of(running_->command, options_.epoch, to_wire(result.outcome));
    if (result.faults != 0) outcome.detail("fault: " + control::fault_text(result.faults));
    outcome.first_sequence(result.first_sequence);
    outcome.onset_sequence(result.has_onset ? result.onset_sequence : result.last_sequence);
    outcome.last_sequence(result.last_sequence);
    outcome.is_onset_marked(result.is_onset_marked);
    outcome.mark_sequence(result.mark_sequence);
    running_.reset();
    end_trial(outcome);
  }
}

void Agent::publish_outcome(const v1::TrialOutcome& outcome) {
  if (auto sent = endpoints_.outcomes.write(outcome); !sent) {
    spdlog::error("the outcome of trial {} is not published: {}", outcome.program().attempt(),
                  sent.error().message);
  }
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
  state.fault(control::fault_text(loop.faults));
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
