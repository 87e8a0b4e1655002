#include "rig_agent/control/rig_loop.hpp"

#include <cmath>

#include "rig_agent/control/validation.hpp"

namespace tonus::control {
namespace {

constexpr double kRecordedTime = 2.0;  // s, of the flight recorder.
constexpr std::size_t kResultCapacity = 64;

std::array<double, 2> plain(const Eigen::Vector2d& v) { return {v.x(), v.y()}; }

std::uint16_t flag(bool is_set, SampleFlag which) { return is_set ? static_cast<std::uint16_t>(which) : 0; }

// What one channel of the force sensor adds to the force on the arm, N in R: the sensor turns with the outer
// link.
Eigen::Vector2d force_of_channel(const RigGeometry& rig, const RawSample& raw, const Eigen::Vector2d& q,
                                 int channel) {
  const Eigen::Vector2d f = (raw.force_V[static_cast<std::size_t>(channel)] - rig.force_offset_V[channel]) *
                            rig.force_calibration.col(channel);
  const double angle = q[0] + q[1] + rig.force_sensor_angle;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {c * f.x() - s * f.y(), s * f.x() + c * f.y()};
}

Eigen::Vector2d force_in_robot_frame(const RigGeometry& rig, const RawSample& raw, const Eigen::Vector2d& q) {
  return force_of_channel(rig, raw, q, 0) + force_of_channel(rig, raw, q, 1);
}

}  // namespace

Result<std::unique_ptr<RigLoop>> RigLoop::create(drivers::Driver& driver, const LoopConfig& config) {
  if (auto valid = validate(config, driver.capabilities(), driver.geometry()); !valid) return valid.error();
  if (auto valid = tonus::validate(driver.auxiliary_channels(), config.rate / config.sample_divider); !valid)
    return valid.error();
  return std::unique_ptr<RigLoop>(new RigLoop(driver, config));
}

RigLoop::RigLoop(drivers::Driver& driver, const LoopConfig& config)
    : driver_(driver),
      geometry_(driver.geometry()),
      config_(config),
      period_(1.0 / config.rate),
      actuates_(driver.capabilities().actuates),
      keeps_its_own_time_(driver.capabilities().has_own_clock),
      monitor_(config.limits, config.gains, config.model.friction, driver.geometry(), period_, actuates_),
      servo_(driver.geometry().links, config.model, config.gains, period_),
      trial_(config.gains, period_, actuates_),
      recorder_(static_cast<std::size_t>(std::lround(kRecordedTime * config.rate))),
      auxiliary_(driver.auxiliary_channels(), config.rate / config.sample_divider, config.sample_divider),
      commands_(kCommandCapacity),
      replies_(kCommandCapacity),
      samples_(config.sample_capacity, auxiliary_.size()),
      results_(kResultCapacity) {}

bool RigLoop::step(std::int64_t now_ns, unsigned missed_periods) noexcept {
  drivers::Reading reading;
  const drivers::DriverStatus status = driver_.read(reading);
  const Surroundings around = surroundings(now_ns, missed_periods);
  if (status == drivers::DriverStatus::kNoData && !actuates_) return wait_for_recording(around);

  const bool is_usable = monitor_.begin_cycle(status, reading, around);
  CycleInput input = convert(status, reading);
  if (!is_usable) servo_.restart();
  if (is_usable && actuates_) check_handle(reading, input);

  take_commands(input, input.takes_sample || status != drivers::DriverStatus::kOk);
  const bool is_safe = monitor_.latched() != 0;
  const Reference reference = is_safe ? trial_.fail(monitor_.latched()) : trial_.advance(input);
  const Eigen::Vector2d torque = control(reference);
  write(torque);
  if (auxiliary_.size() > 0 && status == drivers::DriverStatus::kOk)
    auxiliary_.collect(driver_, cycle_, missed_periods == 0 || keeps_its_own_time_);

  if (input.takes_sample) take_sample(reading, input);
  if (auxiliary_.size() > 0 && cycle_ % config_.sample_divider == 0) auxiliary_.begin_sample();
  record_cycle(reading, reference, torque, around);
  publish(input);
  return true;
}

// A recording between its segments: stops and commands are heard, and nothing else happens.
bool RigLoop::wait_for_recording(const Surroundings& around) noexcept {
  monitor_.begin_cycle(drivers::DriverStatus::kOk, drivers::Reading{}, around);
  if (trial_.is_running()) trial_.miss_recording();
  CycleInput input;
  input.takes_sample = true;
  input.sequence = sequence_;
  take_commands(input, true);
  if (monitor_.latched() != 0) (void)trial_.fail(monitor_.latched());
  publish(input);
  return false;
}

Surroundings RigLoop::surroundings(std::int64_t now_ns, unsigned missed_periods) noexcept {
  missed_periods_ += missed_periods;
  missed_since_sample_ = missed_since_sample_ || missed_periods > 0;
  Surroundings around;
  around.now_ns = now_ns;
  around.missed_periods = missed_periods;
  // All are signs by themselves and order nothing else.
  around.keep_alive = keep_alive_.load(std::memory_order_relaxed);
  around.is_emergency_stop_asked = emergency_stop_.load(std::memory_order_relaxed) &&
                                   emergency_stop_.exchange(false, std::memory_order_relaxed);
  around.is_hold_asked =
      hold_.load(std::memory_order_relaxed) && hold_.exchange(false, std::memory_order_relaxed);
  around.is_trial_running = trial_.is_running();
  around.has_watchdog_tripped = pulse_ != nullptr && pulse_->has_tripped.load(std::memory_order_relaxed) != 0;
  return around;
}

CycleInput RigLoop::convert(drivers::DriverStatus status, const drivers::Reading& reading) noexcept {
  CycleInput input;
  input.sequence = sequence_;
  input.acquisition_ns = reading.raw.acquisition_ns;
  input.mark = reading.mark;
  input.takes_sample = status == drivers::DriverStatus::kOk && cycle_ % config_.sample_divider == 0;
  input.handle = servo_.estimate();
  if (status == drivers::DriverStatus::kOk) {
    const Eigen::Vector2d q = joint_coordinates(geometry_, reading.raw);
    input.handle.force = force_in_robot_frame(geometry_, reading.raw, q);
  }
  return input;
}

// A device that does not take the torque keeps the last one: it is switched off by its other way.
void RigLoop::write(const Eigen::Vector2d& torque) noexcept {
  const drivers::DriverStatus status = driver_.write(torque);
  monitor_.check_write(status);
  if (status != drivers::DriverStatus::kOk && actuates_) (void)driver_.disable();
  driver_.heartbeat(cycle_ % 2 == 1);
  show_onset();
  if (pulse_ != nullptr) pulse_->cycles.fetch_add(1, std::memory_order_relaxed);
}

void RigLoop::show_onset() noexcept {
  const bool is_perturbing = trial_.phase() == Phase::kPerturbing;
  if (is_perturbing == is_onset_shown_) return;
  is_onset_shown_ = is_perturbing;
  if (driver_.set_onset(is_perturbing) && is_perturbing) trial_.mark(sequence_);
}

void RigLoop::check_handle(const drivers::Reading& reading, CycleInput& input) noexcept {
  const Eigen::Vector2d q = joint_coordinates(geometry_, reading.raw);
  input.handle = servo_.observe(q, input.handle.force);
  monitor_.check_handle(input.handle);
  PlausibilityInput seen;
  seen.raw = reading.raw;
  seen.velocity = input.handle.velocity;
  seen.force = input.handle.force;
  seen.load = servo_.load();
  seen.unexplained = servo_.unexplained_torque();
  seen.sensor_angle = q[0] + q[1] + geometry_.force_sensor_angle;
  seen.channel_loads.col(0) = servo_.load_of(force_of_channel(geometry_, reading.raw, q, 0));
  seen.channel_loads.col(1) = servo_.load_of(force_of_channel(geometry_, reading.raw, q, 1));
  seen.predicted = servo_.predicted_torques();
  seen.given = servo_.given_torque();
  seen.rates = servo_.rates();
  seen.is_in_trial = trial_.is_running();
  seen.is_onset = trial_.is_onset();  // of the cycle before
  seen.is_perturbing = trial_.phase() == Phase::kPerturbing;
  monitor_.check_plausibility(seen);
}

// The control law, its limits and the finite check: what violates them is never written.
Eigen::Vector2d RigLoop::control(const Reference& reference) noexcept {
  const SafetyLimits& limits = config_.limits;
  if (!actuates_) return Eigen::Vector2d::Zero();
  if (reference.mode != ServoMode::kSafe) {
    Eigen::Vector2d torque = servo_.torque(reference);
    if (monitor_.check_torque(torque)) return torque;
  }
  // Damping by a motion that is not known would drive the handle.
  const bool is_motion_known = (monitor_.latched() & kMotionFaults) == 0;
  return servo_.safe_torque(is_motion_known ? limits.safe_damping : 0.0, limits.safe_torque);
}

// A stop acts in the cycle that finds it. A trial starts with a sample: its command, and what stands behind
// it, waits for that.
void RigLoop::take_commands(const CycleInput& input, bool may_start) noexcept {
  while (has_next_command_ || commands_.try_pop(next_command_)) {
    has_next_command_ = next_command_.kind == CommandKind::kStartTrial && !may_start;
    if (has_next_command_) return;
    replies_.try_push(carry_out(next_command_, input));
  }
}

CommandReply RigLoop::carry_out(const Command& command, const CycleInput& input) noexcept {
  CommandReply reply;
  reply.request = command.request;
  switch (command.kind) {
    case CommandKind::kStartTrial:
      if (monitor_.latched() != 0) {
        reply.result = CommandResult::kFaultLatched;
        reply.remaining = monitor_.latched();
      } else if (trial_.is_running()) {
        reply.result = CommandResult::kBusy;
      } else {
        trial_.start(command.program, input);
        driver_.begin_trial({command.program.shoulder, command.program.posture, command.program.segment,
                             command.program.instruction, command.program.kind == TrialKind::kContraction});
      }
      return reply;
    case CommandKind::kAbort:
      reply.result = trial_.is_running() ? CommandResult::kDone : CommandResult::kNothingRunning;
      if (trial_.is_running()) trial_.abort();
      return reply;
    case CommandKind::kClearFaults:
      return clear_faults(command.request);
  }
  return reply;
}

CommandReply RigLoop::clear_faults(std::uint64_t request) noexcept {
  CommandReply reply;
  reply.request = request;
  if (monitor_.latched() == 0) {
    reply.result = CommandResult::kNothingRunning;
    return reply;
  }
  reply.remaining = actuates_ && !servo_.is_released() ? monitor_.latched() : monitor_.clear();
  if (reply.remaining != 0) {
    reply.result = CommandResult::kCauseRemains;
    return reply;
  }
  trial_.recover();
  return reply;
}

void RigLoop::take_sample(const drivers::Reading& reading, const CycleInput& input) noexcept {
  SampleRecord sample;
  sample.sequence = sequence_;
  sample.trial = trial_.trial();
  sample.raw = reading.raw;
  sample.commanded = actuates_ ? trial_.commanded() : reading.recorded_command;
  sample.bias = trial_.bias();
  sample.phase = trial_.phase();
  sample.flags = static_cast<std::uint16_t>(
      flag(trial_.is_onset(), SampleFlag::kOnset) | flag(monitor_.is_saturated(), SampleFlag::kSaturated) |
      flag(monitor_.latched() != 0, SampleFlag::kFault) | flag(missed_since_sample_, SampleFlag::kOverrun) |
      flag(trial_.is_at_rest(), SampleFlag::kAtRest));
  samples_.try_push(sample, auxiliary_.row());
  trial_.sampled(sequence_, input.acquisition_ns);
  last_endpoint_ = tonus::convert(geometry_, trial_.shoulder(), reading.raw);
  missed_since_sample_ = false;
  ++sequence_;
}

void RigLoop::record_cycle(const drivers::Reading& reading, const Reference& reference,
                           const Eigen::Vector2d& torque, const Surroundings& around) noexcept {
  const HandleEstimate& handle = servo_.estimate();
  CycleRecord cycle;
  cycle.cycle = cycle_;
  cycle.now_ns = around.now_ns;
  cycle.raw = reading.raw;
  cycle.position = plain(handle.measured);
  cycle.velocity = plain(handle.velocity);
  cycle.force = plain(handle.force);
  cycle.reference = plain(reference.position);
  cycle.torque = plain(torque);
  cycle.faults = monitor_.latched();
  cycle.missed_periods = around.missed_periods;
  cycle.phase = trial_.phase();
  if (monitor_.latched() == 0) recorder_.release_if_read();
  recorder_.put(cycle);
  if (monitor_.latched() != 0) recorder_.freeze();
  ++cycle_;
}

void RigLoop::publish(const CycleInput& input) noexcept {
  LoopState state;
  state.cycle = cycle_;
  state.next_sequence = sequence_;
  state.trial = trial_.trial();
  state.acquisition_ns = input.acquisition_ns;
  state.phase = trial_.phase();
  state.faults = monitor_.latched();
  state.missed_periods = missed_periods_;
  state.samples_dropped = samples_.dropped();
  state.answers_dropped = replies_.dropped() + results_.dropped();
  state.position = plain(last_endpoint_.p_SE);
  state.force = plain(last_endpoint_.f_S);
  state_.store(state);

  TrialResult result;
  if (trial_.take_result(result)) results_.try_push(result);
}

}  // namespace tonus::control
