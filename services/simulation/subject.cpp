#include "services/simulation/subject.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "services/mechanics/two_link_dynamics.hpp"

namespace tonus::simulation {
namespace {

constexpr double kRestTracking = 1.0;  // s, time constant with which the felt rest position follows the hand.
constexpr double kLoadTracking = 0.5;  // s, with which the muscles' activity follows a load that is held.
constexpr double kCalmTime = 0.3;      // s near rest, after which a perturbation is over for the subject.

// Streams of the profile's seed; the sensors have 0.
constexpr std::uint64_t kTremorStream = 1;
constexpr std::uint64_t kDriftStream = 2;
constexpr std::uint64_t kReactionStream = 3;

}  // namespace

Subject::Subject(const SubjectProfile& profile, double period, std::uint64_t seed)
    : profile_(profile),
      period_(period),
      tremor_noise_(seed, kTremorStream),
      drift_noise_(seed, kDriftStream),
      reaction_noise_(seed, kReactionStream),
      past_(std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(profile.reflex.delay / period)))),
      misconduct_(profile.misconduct, period) {
  take_posture(profile.posture);
}

void Subject::take_posture(const Eigen::Vector2d& posture) noexcept {
  posture_ = posture;
  rest_ = posture;
  is_provoked_ = false;
  offset_.setZero();
  held_force_ = 0.0;
  load_.setZero();
  felt_rates_.setZero();
  drive_.equilibrium = profile_.links.angles_at(posture);
  std::fill(past_.begin(), past_.end(), Past{});
}

const SubjectDrive& Subject::begin_period(const ArmMotion& arm) noexcept {
  drive_.force.setZero();
  drive_.is_holding = true;
  if (arm.hand_velocity.norm() > profile_.recentring.speed) quick_until_ = time_ + profile_.recentring.pause;
  tension_ = 0.0;
  if (profile_.misconduct.is_on) misbehave(arm);
  contract();
  if (profile_.modulation.is_on) modulate(arm);
  drive_.scale = 1.0;
  if (profile_.modulation.is_on) drive_.scale += profile_.modulation.gain * held_force_;
  const MuscleProfile& muscles = profile_.muscles;
  drive_.scale *= 1.0 + (tension_ + contraction_ * (1.0 - muscles.rest)) / muscles.per_stiffness;
  effort_ = drive_.scale;
  if (profile_.fatigue.is_on) {
    drive_.scale *= 1.0 - profile_.fatigue.depth * (1.0 - std::exp(-time_ / profile_.fatigue.time_constant));
  }
  if (profile_.recentring.is_on) recentre(arm);
  if (profile_.reflex.is_on) drive_.torque = reflex_torque(arm);
  if (profile_.tremor.is_on) {
    tremor_force_ = tremor_force();
    drive_.force += tremor_force_;
  }
  if (profile_.drift.is_on) drive_.force += drift_force();
  if (profile_.reaction.is_on) drive_.force += reaction_force(arm);
  if (profile_.letting_go.is_on) {
    const double since = time_ - profile_.letting_go.at;
    drive_.is_holding &= since < 0.0 || since >= profile_.letting_go.duration;
  }
  hold_load(arm);
  time_ += period_;
  return drive_;
}

// From the onset that he sees on, after his latency, as hard as he can, until it is over.
void Subject::contract() noexcept {
  const MuscleProfile& muscles = profile_.muscles;
  const double step = period_ / muscles.contraction_rise;
  const bool is_pulling = contracts_ && time_ >= shown_at_ + muscles.contraction_latency;
  contraction_ = std::clamp(contraction_ + (is_pulling ? step : -step), 0.0, 1.0);
}

Eigen::Vector2d Subject::muscle_torque(const ArmMotion& arm) const noexcept {
  return drive_.scale *
         ((profile_.stiffness.matrix() + drive_.added.stiffness) * (drive_.equilibrium - arm.angles));
}

// A quick motion stretches the muscles without that they are asked for more.
void Subject::hold_load(const ArmMotion& arm) noexcept {
  angles_ = arm.angles;
  if (time_ < quick_until_) return;
  load_ += (period_ / kLoadTracking) * (muscle_torque(arm) - load_);
}

Activations Subject::activation() const noexcept {
  const Eigen::Matrix2d to_joints = profile_.links.jacobian(angles_).transpose();
  MuscleDemand demand;
  demand.stiffness = effort_ * (profile_.stiffness.matrix() + drive_.added.stiffness);
  demand.load = load_;
  demand.push = to_joints * (drive_.force - tremor_force_);
  demand.tremor = to_joints * tremor_force_;
  demand.tremor_frequency = profile_.tremor.frequency;
  demand.felt_rates = felt_rates_;
  return activations(profile_, demand);
}

Eigen::Vector2d Subject::reflex_torque(const ArmMotion& arm) noexcept {
  const Past then = past_[past_next_];
  past_[past_next_] = {arm.angles - drive_.equilibrium, arm.rates};
  past_next_ = (past_next_ + 1) % past_.size();
  felt_rates_ = then.rates;
  return -(profile_.reflex.stiffness.matrix() * then.deviation +
           profile_.reflex.damping.matrix() * then.rates);
}

// Narrow-band noise: z <- z exp((-b + i w) h) + complex noise; its real part has the wanted variance.
Eigen::Vector2d Subject::tremor_force() noexcept {
  const TremorEffect& tremor = profile_.tremor;
  const double decay = std::exp(-2.0 * std::numbers::pi * tremor.bandwidth * period_);
  const auto turn = std::polar(decay, 2.0 * std::numbers::pi * tremor.frequency * period_);
  const double spread = tremor.force * std::sqrt(1.0 - decay * decay);
  for (auto& z : tremor_) {
    const double re = tremor_noise_.normal();
    const double im = tremor_noise_.normal();
    z = z * turn + spread * std::complex<double>(re, im);
  }
  return {tremor_[0].real(), tremor_[1].real()};
}

Eigen::Vector2d Subject::drift_force() noexcept {
  const double decay = std::exp(-period_ / profile_.drift.time_constant);
  const double spread = profile_.drift.force * std::sqrt(1.0 - decay * decay);
  const double x = drift_noise_.normal();
  const double y = drift_noise_.normal();
  drift_ = decay * drift_ + spread * Eigen::Vector2d(x, y);
  return drift_;
}

Eigen::Vector2d Subject::reaction_force(const ArmMotion& arm) noexcept {
  const ReactionEffect& reaction = profile_.reaction;
  const Eigen::Vector2d displacement = arm.hand - rest_;
  if (!is_provoked_) {
    rest_ += (period_ / kRestTracking) * displacement;
    if (displacement.norm() < reaction.threshold) return Eigen::Vector2d::Zero();
    is_provoked_ = true;
    answers_ = reaction_noise_.uniform() < reaction.probability;
    provoked_at_ = time_;
    calm_since_ = time_;
    reaction_direction_ = -displacement.normalized();
  }
  if (displacement.norm() > 0.5 * reaction.threshold) calm_since_ = time_;
  if (time_ - calm_since_ > kCalmTime) is_provoked_ = false;
  if (!is_provoked_ || !answers_) return Eigen::Vector2d::Zero();
  const double share = std::clamp((time_ - provoked_at_ - reaction.latency) / reaction.rise, 0.0, 1.0);
  return share * reaction.force * reaction_direction_;
}

void Subject::recentre(const ArmMotion& arm) noexcept {
  const RecentringEffect& effect = profile_.recentring;
  if (time_ < quick_until_ || !profile_.links.reaches(arm.hand)) return;
  const Eigen::Matrix2d jacobian = profile_.links.jacobian(arm.angles);
  drive_.equilibrium +=
      (period_ / effect.time_constant) * (control::inverse(jacobian) * (posture_ + offset_ - arm.hand));
}

// The muscles' steady torque, as a force at the hand: f = J^-T K (t_eq - t).
void Subject::modulate(const ArmMotion& arm) noexcept {
  if (time_ < quick_until_ || !profile_.links.reaches(arm.hand)) return;
  const Eigen::Matrix2d jacobian = profile_.links.jacobian(arm.angles);
  const double force = (control::inverse(jacobian).transpose() * muscle_torque(arm)).norm();
  held_force_ += (period_ / profile_.modulation.time_constant) * (force - held_force_);
}

void Subject::misbehave(const ArmMotion& arm) noexcept {
  const Misconduct::Act act = misconduct_.begin_period(arm.hand_velocity.norm());
  drive_.force += act.force;
  drive_.is_holding = act.is_holding;
  tension_ = act.tension;
  if (act.offset == offset_) return;
  if (profile_.links.reaches(arm.hand)) {
    const Eigen::Matrix2d jacobian = profile_.links.jacobian(arm.angles);
    drive_.equilibrium += control::inverse(jacobian) * (act.offset - offset_);
  }
  offset_ = act.offset;
}

}  // namespace tonus::simulation
