#include "rig_agent/control/trial_machine.hpp"

#include <algorithm>
#include <cmath>

namespace tonus::control {
namespace {

// Minimum-jerk way from 0 to 1 over s in [0, 1]: value and first two derivatives by s.
struct MinimumJerk {
  double value = 1.0;
  double slope = 0.0;
  double curvature = 0.0;

  explicit MinimumJerk(double s) {
    if (!(s < 1.0)) return;
    value = s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
    slope = 30.0 * s * s * (1.0 - s) * (1.0 - s);
    curvature = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s);
  }
};

Eigen::Matrix2d rotation(double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  Eigen::Matrix2d r;
  r << c, -s, s, c;
  return r;
}

}  // namespace

TrialMachine::TrialMachine(const ServoGains& gains, double period, bool actuates)
    : gains_(gains),
      period_(period),
      actuates_(actuates),
      force_filter_(1.0 - std::exp(-gains.force_filter * period)) {}

void TrialMachine::start(const TrialProgram& program, const CycleInput& input) noexcept {
  program_ = program;
  shoulder_to_robot_ = rotation(program.shoulder.angle);
  target_ = program.shoulder.origin + shoulder_to_robot_ * program.posture;
  path_start_ = input.handle.position;
  path_end_ = target_;
  result_ = TrialResult{};
  result_.number = program.number;
  result_.first_sequence = input.sequence;
  has_result_ = false;
  is_last_row_ = false;
  enter(actuates_ ? Phase::kCentring : Phase::kWaiting);
}

Reference TrialMachine::advance(const CycleInput& input) noexcept {
  is_onset_ = false;
  is_at_rest_ = input.handle.velocity.norm() < program_.rest_speed;
  filtered_force_ += force_filter_ * (input.handle.force - filtered_force_);
  if (is_running()) {
    if (actuates_) {
      step_phase(input);
    } else {
      step_recording(input);
    }
  }
  Reference wish = reference();
  ++cycles_in_phase_;
  return wish;
}

void TrialMachine::step_phase(const CycleInput& input) noexcept {
  switch (phase_) {
    case Phase::kCentring:
      count_calm(is_at_rest_ && (input.handle.measured - target_).norm() < program_.centring_tolerance);
      if (!input.takes_sample) return;
      if (has_lasted(program_.centring_time) && spans(calm_cycles_, program_.rest_time)) {
        return enter(Phase::kWaiting);
      }
      if (has_lasted(program_.centring_timeout)) end(TrialOutcome::kNotCentred, 0);
      return;
    case Phase::kWaiting:
      if (!input.takes_sample || !has_lasted(program_.wait)) return;
      return has_bias() ? enter(Phase::kBiasRamp) : begin_perturbation(input);
    case Phase::kBiasRamp:
      if (input.takes_sample && has_lasted(program_.bias_ramp)) enter(Phase::kBiasHold);
      return;
    case Phase::kBiasHold:
      count_calm((filtered_force_ - shoulder_to_robot_ * program_.bias).norm() < program_.bias_threshold);
      if (!input.takes_sample) return;
      if (spans(calm_cycles_, program_.bias_hold)) return begin_perturbation(input);
      if (has_lasted(program_.bias_timeout)) end(TrialOutcome::kBiasNotReached, 0);
      return;
    case Phase::kPerturbing:
      if (input.takes_sample && has_lasted(program_.hold)) begin_return(input);
      return;
    case Phase::kReturning:
      if (input.takes_sample && has_lasted(program_.return_time)) end(TrialOutcome::kCompleted, 0);
      return;
    case Phase::kIdle:
    case Phase::kSafe:
      return;
  }
}

void TrialMachine::step_recording(const CycleInput& input) noexcept {
  is_last_row_ = input.mark == drivers::RowMark::kLast;
  if (input.mark == drivers::RowMark::kOnset) begin_perturbation(input);
}

void TrialMachine::begin_perturbation(const CycleInput& input) noexcept {
  enter(Phase::kPerturbing);
  onset_position_ = input.handle.position;
  is_onset_ = true;
  result_.has_onset = true;
  result_.onset_sequence = input.sequence;
  result_.onset_ns = input.acquisition_ns;
}

void TrialMachine::begin_return(const CycleInput& input) noexcept {
  enter(Phase::kReturning);
  path_start_ = input.handle.position;
  path_end_ = onset_position_;
}

Reference TrialMachine::reference() noexcept {
  commanded_ = {};
  switch (phase_) {
    case Phase::kCentring: {
      bias_ = {};
      return lead(program_.centring_time);
    }
    case Phase::kWaiting: {
      Reference wish = exert(0.0, ServoMode::kFloat);
      wish.corrects_force = true;
      return wish;
    }
    case Phase::kBiasRamp: {
      Reference wish = exert(MinimumJerk(elapsed() / program_.bias_ramp).value, ServoMode::kFloat);
      wish.corrects_force = true;
      return wish;
    }
    case Phase::kBiasHold: {
      Reference wish = exert(1.0, ServoMode::kFloat);
      wish.corrects_force = true;
      return wish;
    }
    case Phase::kPerturbing: {
      if (is_contraction()) return hold_still();
      const Eigen::Vector2d step =
          program_.amplitude * Eigen::Vector2d(std::cos(program_.direction), std::sin(program_.direction));
      commanded_ = {step.x(), step.y()};
      Reference wish = exert(1.0, ServoMode::kRing);
      wish.position = onset_position_ + shoulder_to_robot_ * step;
      wish.frequency = gains_.perturbation_phase / program_.rise_time;
      return wish;
    }
    case Phase::kReturning: {
      Reference wish = lead(program_.return_time);
      if (is_contraction()) return wish;
      wish.force = exert(1.0 - MinimumJerk(elapsed() / program_.return_time).value, ServoMode::kLead).force;
      return wish;
    }
    case Phase::kIdle:
    case Phase::kSafe:
      break;
  }
  bias_ = {};
  Reference wish;
  wish.mode = phase_ == Phase::kSafe ? ServoMode::kSafe : ServoMode::kFloat;
  return wish;
}

Reference TrialMachine::lead(double duration) const noexcept {
  const MinimumJerk way(elapsed() / duration);
  const Eigen::Vector2d distance = path_end_ - path_start_;
  Reference wish;
  wish.mode = ServoMode::kLead;
  wish.position = path_start_ + way.value * distance;
  wish.velocity = (way.slope / duration) * distance;
  wish.acceleration = (way.curvature / (duration * duration)) * distance;
  return wish;
}

Reference TrialMachine::hold_still() const noexcept {
  Reference wish;
  wish.mode = ServoMode::kLead;
  wish.position = onset_position_;
  return wish;
}

Reference TrialMachine::exert(double share_of_bias, ServoMode mode) noexcept {
  const Eigen::Vector2d bias = share_of_bias * program_.bias;
  bias_ = {bias.x(), bias.y()};
  Reference wish;
  wish.mode = mode;
  wish.force = shoulder_to_robot_ * bias;
  return wish;
}

Reference TrialMachine::fail(FaultBits faults) noexcept {
  is_onset_ = false;
  if (is_running()) end(TrialOutcome::kFault, faults);
  phase_ = Phase::kSafe;
  return reference();
}

void TrialMachine::recover() noexcept {
  if (phase_ == Phase::kSafe) enter(Phase::kIdle);
}

void TrialMachine::enter(Phase phase) noexcept {
  phase_ = phase;
  cycles_in_phase_ = 0;
  calm_cycles_ = 0;
}

void TrialMachine::end(TrialOutcome outcome, FaultBits faults) noexcept {
  result_.outcome = outcome;
  result_.faults = faults;
  result_.ended_in = phase_;
  result_.last_sequence = last_sequence_;
  result_.last_ns = last_ns_;
  has_result_ = true;
  enter(Phase::kIdle);
}

bool TrialMachine::take_result(TrialResult& result) noexcept {
  if (!has_result_) return false;
  result = result_;
  has_result_ = false;
  return true;
}

void TrialMachine::sampled(std::uint64_t sequence, std::int64_t acquisition_ns) noexcept {
  if (!is_running()) return;
  if (sequence == result_.first_sequence) result_.first_ns = acquisition_ns;
  ++result_.samples;
  last_sequence_ = sequence;
  last_ns_ = acquisition_ns;
  if (is_last_row_) end(TrialOutcome::kCompleted, 0);
}

// A duration ends with the first cycle at or after it; the small part forgives the rounding of the quotient.
bool TrialMachine::spans(std::uint64_t cycles, double duration) const noexcept {
  return static_cast<double>(cycles) >= duration / period_ - 1e-6;
}

}  // namespace tonus::control
