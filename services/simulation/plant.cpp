#include "services/simulation/plant.hpp"

#include <algorithm>
#include <cmath>

#include "services/simulation/true_impedance.hpp"

namespace tonus::simulation {
namespace {

constexpr std::uint64_t kSensorStream = 0;

Eigen::Matrix2d rotation(double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  Eigen::Matrix2d r;
  r << c, -s, s, c;
  return r;
}

}  // namespace

Plant::Plant(const PlantProfile& profile, double period)
    : profile_(profile),
      geometry_(rig_geometry(profile)),
      inertia_(manipulandum_model(profile.manipulandum, profile.sensors.handle_mass).inertia),
      arm_inertia_(cylinder_inertia(profile.subject)),
      period_ns_(std::llround(1e9 * period)),
      period_(period),
      sub_step_(period / profile.sub_steps),
      motor_decay_half_(profile.manipulandum.motor_time_constant > 0.0
                            ? std::exp(-0.5 * sub_step_ / profile.manipulandum.motor_time_constant)
                            : 0.0),
      stiffness_(profile.subject.stiffness.matrix()),
      damping_(profile.subject.damping.matrix()),
      subject_(profile.subject, period, profile.seed),
      sensor_noise_(profile.seed, kSensorStream),
      rig_(profile.manipulandum.links, q_),
      arm_(profile.subject.links, t_) {
  state_.q = profile.manipulandum.links.angles_at(profile.manipulandum.home);
  ShoulderPose shoulder;
  shoulder.origin = profile.manipulandum.home - profile.subject.posture;
  seat(shoulder, profile.subject.posture);
}

void Plant::seat(const ShoulderPose& shoulder, const Eigen::Vector2d& posture) noexcept {
  shoulder_to_robot_ = rotation(shoulder.angle);
  shoulder_origin_ = shoulder.origin;
  subject_.take_posture(profile_.bench.is_on ? profile_.subject.posture : posture);
  is_holding_ = false;
  take_hold();
  evaluate_sines();
}

void Plant::evaluate_sines() noexcept {
  q_ = state_.q;
  t_ = state_.t;
  rig_ = control::TwoLinkState(profile_.manipulandum.links, q_);
  arm_ = control::TwoLinkState(profile_.subject.links, t_);
}

// Puts the hand on the handle, moving with it. A hand that cannot reach stays where it is, open.
void Plant::take_hold() noexcept {
  const TwoLink& arm = profile_.subject.links;
  const control::TwoLinkState rig(profile_.manipulandum.links, state_.q);
  if (profile_.bench.is_on) {
    state_.t = arm.angles_at(profile_.subject.posture);
    return;
  }
  const Eigen::Vector2d hand = shoulder_to_robot_.transpose() * (rig.point - shoulder_origin_);
  is_holding_ = arm.reaches(hand);
  if (!is_holding_) return;
  state_.t = arm.angles_at(hand);
  const Eigen::Vector2d velocity = shoulder_to_robot_.transpose() * (rig.jacobian * state_.q_rate);
  state_.t_rate = control::inverse(arm.jacobian(state_.t)) * velocity;
}

void Plant::step(const Eigen::Vector2d& torque) noexcept {
  const Eigen::Vector2d& limit = profile_.manipulandum.torque_limits;
  const Eigen::Vector2d given = profile_.manipulandum.motor_gains.cwiseProduct(torque);
  const Eigen::Vector2d command = given.cwiseMin(limit).cwiseMax(-limit);
  evaluate_sines();
  const SubjectDrive& drive =
      subject_.begin_period({state_.t, state_.t_rate, arm_.point, arm_.jacobian * state_.t_rate});
  if (profile_.bench.is_on) {
    is_holding_ = false;
  } else if (drive.is_holding && !is_holding_) {
    take_hold();
  } else {
    is_holding_ = drive.is_holding;
  }
  for (unsigned i = 0; i < profile_.sub_steps; ++i) runge_kutta_step(command);
  ++step_count_;
}

// Classical fourth order in (q, t, q', t'). The motors' lag is solved in closed form at the stages' times.
void Plant::runge_kutta_step(const Eigen::Vector2d& command) noexcept {
  const double h = sub_step_;
  const PlantState start = state_;
  const auto stage = [&](const Eigen::Vector4d& angle_step, const Eigen::Vector4d& rate_step, double decay) {
    PlantState s;
    s.q = start.q + angle_step.head<2>();
    s.t = start.t + angle_step.tail<2>();
    s.q_rate = start.q_rate + rate_step.head<2>();
    s.t_rate = start.t_rate + rate_step.tail<2>();
    s.motor = command + decay * (start.motor - command);
    return s;
  };
  Eigen::Vector4d v1;
  v1 << start.q_rate, start.t_rate;
  const Eigen::Vector4d a1 = accelerations(start);
  const Eigen::Vector4d v2 = v1 + 0.5 * h * a1;
  const Eigen::Vector4d a2 = accelerations(stage(0.5 * h * v1, 0.5 * h * a1, motor_decay_half_));
  const Eigen::Vector4d v3 = v1 + 0.5 * h * a2;
  const Eigen::Vector4d a3 = accelerations(stage(0.5 * h * v2, 0.5 * h * a2, motor_decay_half_));
  const double decay = motor_decay_half_ * motor_decay_half_;
  const Eigen::Vector4d v4 = v1 + h * a3;
  const Eigen::Vector4d a4 = accelerations(stage(h * v3, h * a3, decay));
  state_ = stage((h / 6.0) * (v1 + 2.0 * (v2 + v3) + v4), (h / 6.0) * (a1 + 2.0 * (a2 + a3) + a4), decay);
}

Plant::Chains Plant::chains(const PlantState& state) const noexcept {
  Chains c{rig_.moved_by(profile_.manipulandum.links, q_, state.q - q_),
           arm_.moved_by(profile_.subject.links, t_, state.t - t_), Eigen::Matrix2d::Zero(),
           Eigen::Vector2d::Zero()};
  c.arm_jacobian = shoulder_to_robot_ * c.arm.jacobian;
  if (is_holding_) {
    const Eigen::Vector2d stretch = c.rig.point - shoulder_origin_ - shoulder_to_robot_ * c.arm.point;
    const Eigen::Vector2d stretch_rate = c.rig.jacobian * state.q_rate - c.arm_jacobian * state.t_rate;
    c.grip = profile_.grip.stiffness * stretch + profile_.grip.damping * stretch_rate;
  } else if (profile_.bench.is_on) {
    const BenchProfile& bench = profile_.bench;
    const Eigen::Vector2d stretch = c.rig.point - profile_.manipulandum.home;
    c.grip =
        bench.spring.cwiseProduct(stretch) + bench.damping * (c.rig.jacobian * state.q_rate) - bench.load;
  }
  return c;
}

// (q'', t'') of the equations of motion in the header.
Eigen::Vector4d Plant::accelerations(const PlantState& state, const Chains& c) const noexcept {
  const SubjectDrive& drive = subject_.drive();

  const Eigen::Vector2d rig_torque = state.motor - profile_.manipulandum.friction.torque(state.q_rate) -
                                     inertia_.coriolis(c.rig.sin_q2, state.q_rate) -
                                     c.rig.jacobian.transpose() * c.grip;
  const Eigen::Vector2d muscle =
      drive.torque - drive.scale * ((stiffness_ + drive.added.stiffness) * (state.t - drive.equilibrium) +
                                    (damping_ + drive.added.damping) * state.t_rate);
  const Eigen::Vector2d arm_torque = muscle - arm_inertia_.coriolis(c.arm.sin_q2, state.t_rate) +
                                     c.arm.jacobian.transpose() * drive.force +
                                     (is_holding_ ? 1.0 : 0.0) * (c.arm_jacobian.transpose() * c.grip);
  Eigen::Vector4d a;
  a << control::inverse(inertia_.mass_matrix(c.rig.cos_q2)) * rig_torque,
      control::inverse(arm_inertia_.mass_matrix(c.arm.cos_q2)) * arm_torque;
  if (profile_.bench.is_clamped) a.head<2>().setZero();
  return a;
}

Eigen::Vector2d Plant::handle() const noexcept { return profile_.manipulandum.links.endpoint(state_.q); }

Eigen::Vector2d Plant::flexure_force() const noexcept {
  const Chains c = chains(state_);
  if (profile_.sensors.handle_mass == 0.0) return c.grip;
  const Eigen::Vector2d acceleration =
      c.rig.jacobian * accelerations(state_, c).head<2>() + c.rig.jacobian_rate_times_rates(state_.q_rate);
  return c.grip + profile_.sensors.handle_mass * acceleration;
}

RawSample Plant::measure() noexcept {
  const SensorProfile& sensors = profile_.sensors;
  RawSample raw;
  raw.acquisition_ns = time_ns();
  for (std::size_t i = 0; i < 2; ++i) {
    const auto joint = static_cast<Eigen::Index>(i);
    raw.encoder_count[i] = std::floor(geometry_.encoder_zero[i] + sensors.errors.zero_count[joint] +
                                      state_.q[joint] * geometry_.counts_per_unit[i]);
  }
  const Eigen::Vector2d f_R = flexure_force();
  const double angle = state_.q[0] + state_.q[1] + sensors.force_sensor_angle;
  const Eigen::Vector2d f_true = rotation(-angle) * f_R;
  const Eigen::Vector2d f_sensor(sensors.errors.force_row_x.dot(f_true),
                                 sensors.errors.force_row_y.dot(f_true));
  const double volts_per_newton = sensors.voltage_full_scale / sensors.force_full_scale;
  const double step = sensors.force_resolution * volts_per_newton;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const double force = f_sensor[axis] + sensors.force_noise * sensor_noise_.normal();
    const double volts =
        force * volts_per_newton + sensors.force_offset_V[axis] + sensors.errors.offset_V[axis];
    const double rounded = step > 0.0 ? step * std::round(volts / step) : volts;
    raw.force_V[i] = std::clamp(rounded, -sensors.voltage_full_scale, sensors.voltage_full_scale);
  }
  return raw;
}

double Plant::energy() const noexcept {
  const Chains c = chains(state_);
  const SubjectDrive& drive = subject_.drive();
  const Eigen::Vector2d bend = state_.t - drive.equilibrium;
  const Eigen::Vector2d stretch = c.rig.point - shoulder_origin_ - shoulder_to_robot_ * c.arm.point;
  return 0.5 * (state_.q_rate.dot(inertia_.mass_matrix(c.rig.cos_q2) * state_.q_rate) +
                state_.t_rate.dot(arm_inertia_.mass_matrix(c.arm.cos_q2) * state_.t_rate) +
                drive.scale * bend.dot((stiffness_ + drive.added.stiffness) * bend) +
                (is_holding_ ? profile_.grip.stiffness * stretch.squaredNorm() : 0.0));
}

}  // namespace tonus::simulation
