#pragma once

#include "rig_agent/control/safety_limits.hpp"
#include "rig_agent/control/servo_gains.hpp"

namespace tonus::control {

/// Calls visit(key, value, low, high) for each setting, `key` as on the wire and in files, with its unit, and
/// `low` and `high` inclusive. `value` is a double, an unsigned or an Eigen::Vector2d, whose parts have the
/// same range.
///
/// The ranges are the ceilings of this program: no file and no option goes beyond them.
/// - Workspace: a seated subject's hand goes about 0.25 m from the middle of its reach before the elbow is
///   straight, where a push goes into the joint itself.
/// - Speed and energy: what an arm of some 2 kg at the hand takes up in a stop without harm, 1.5 m/s or 2 J,
///   and what the centring needs.
/// - Force: ISO/TS 15066, annex A, names 140 N for a hand that is held fast; a hand that holds a handle
///   cannot let go at once, and 100 N leave a margin for the sensor. Torque, 100 N m, moves the links too.
/// - Damping of the safe state: with 3 N m s/rad a reversed encoder drove the hand out of the workspace in 2
///   of 2000 stops before that was seen, with 2 in none.
/// - Time: a person takes 0.2 s to let go; a stop has to come before a second one is needed.
template <typename Limits, typename Visit>
void for_each_limit(Limits& limits, const Visit& visit) {
  visit("workspace_centre_m", limits.workspace_centre, -4.0, 4.0);
  visit("workspace_radius_m", limits.workspace_radius, 0.005, 0.25);
  visit("speed_m_per_s", limits.speed, 0.01, 1.5);
  visit("force_N", limits.force, 0.5, 100.0);
  visit("torques_Nm", limits.torque, 0.01, 100.0);
  visit("encoder_jump_rad", limits.encoder_jump, 1e-4, 0.1);
  visit("command_timeout_s", limits.command_timeout, 0.0, 5.0);
  visit("missed_periods", limits.missed_periods, 0u, 10000u);
  visit("missed_share", limits.missed_share, 0.0, 0.9);
  visit("unexplained_torque_Nm", limits.unexplained_torque, 0.0, 10.0);
  visit("trial_energy_J", limits.trial_energy, 0.0, 10.0);
  visit("watchdog_s", limits.watchdog, 0.005, 0.1);
  visit("safe_damping_Nms_per_rad", limits.safe_damping, 0.1, 2.0);
  visit("safe_torque_Nm", limits.safe_torque, 0.1, 10.0);
}

/// The same for the gains.
template <typename Gains, typename Visit>
void for_each_gain(Gains& gains, const Visit& visit) {
  visit("perturbation_phase_rad", gains.perturbation_phase, 1.0, 10.0);
  visit("perturbation_damping", gains.perturbation_damping, 0.0, 1.0);
  visit("hold_frequency_rad_per_s", gains.hold_frequency, 1.0, 100.0);
  visit("hold_damping", gains.hold_damping, 0.3, 2.0);
  visit("float_damping_per_s", gains.float_damping, 0.1, 100.0);
  visit("force_trim_per_s", gains.force_trim, 0.0, 10.0);
  visit("force_trim_limit_N", gains.force_trim_limit, 0.0, 20.0);
  visit("observer_frequency_rad_per_s", gains.observer_frequency, 5.0, 500.0);
  visit("force_filter_rad_per_s", gains.force_filter, 1.0, 1000.0);
  visit("friction_compensation", gains.friction_compensation, 0.0, 1.0);
}

}  // namespace tonus::control
