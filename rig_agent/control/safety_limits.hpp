#pragma once

#include <Eigen/Core>

namespace tonus::control {

/// What the loop stops at. SI; lengths and positions in the robot's base frame R. Checked in every cycle,
/// before any torque is written; the cycle that finds a violation already writes the safe torque.
struct SafetyLimits {
  Eigen::Vector2d workspace_centre{0.30, 0.35};  ///< m.
  double workspace_radius = 0.08;                ///< m, about the centre.
  double speed = 0.8;                            ///< m/s, handle.
  double force = 30.0;                           ///< N, measured at the handle.
  Eigen::Vector2d torque{15.0, 15.0};            ///< N m, demanded at each joint.
  double encoder_jump = 0.02;                    ///< rad in one cycle, each joint.
  double command_timeout = 1.0;     ///< s without keep_alive() during a trial; 0 switches it off.
  unsigned missed_periods = 25;     ///< Periods missed at once; 0 switches it off.
  double missed_share = 0.4;        ///< Of the periods of about a second, missed; 0 switches it off.
  double unexplained_torque = 2.0;  ///< N m at a joint that the model cannot explain; 0 switches it off.
  double trial_energy = 3.0;        ///< J given to the hand in a trial; 0 switches it off.
  double watchdog = 0.02;           ///< s without a cycle after which the watchdog drops the torque.
  double safe_damping = 1.0;        ///< N m s/rad, in the safe state until at rest.
  double safe_torque = 3.0;         ///< N m, largest damping torque in the safe state.
};

}  // namespace tonus::control
