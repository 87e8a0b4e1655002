#pragma once

namespace tonus::control {

/// Constants of the control law (servo.hpp). Per unit of the manipulandum's own mass matrix at the handle, so
/// that they hold in every direction.
///
/// How the perturbation was tuned. The published traces command 5 mm, rise in 0.2 s, reach up to 10 mm and
/// about 1.5 m/s2. An underdamped step A w^2 has its first peak at pi / w: with A = 5 mm, 0.2 s gives 1.2
/// m/s2 and 1.5 m/s2 gives 0.18 s. Phase 3.6 (18 rad/s for 0.2 s) lies between, and rings enough to tell mass
/// from stiffness. The default manipulandum is 7.6 by 9.0 kg at the handle, heavier than the arm (0.5 to 3.6
/// kg), so that all postures and directions move alike: in simulation first peaks at 0.17 to 0.19 s,
/// excursions of 6.8 to 8.8 mm and 1.1 to 1.6 m/s2. With the published sensors, 16 perturbations identify M,
/// B and K by the state-variable method within 2 % of the largest element at all five postures (seeds 1 to
/// 8); with a lighter handle (5.9 by 7.4 kg), 3.3 %.
struct ServoGains {
  /// Natural frequency of the perturbation's servo times the program's rise time, rad. The arm in the hand
  /// shares the servo's force, which is why it is not pi.
  double perturbation_phase = 3.6;
  double perturbation_damping = 0.05;  ///< Damping ratio of the servo alone; the arm adds its own.
  double hold_frequency = 20.0;        ///< rad/s, while leading the handle.
  double hold_damping = 0.9;           ///< Damping ratio, while leading the handle.
  double float_damping = 5.0;          ///< 1/s, while the force is controlled.
  double force_trim = 0.4;             ///< 1/s, integral gain from force error to force.
  double force_trim_limit = 1.5;       ///< N, largest correction by the integral.
  double observer_frequency = 40.0;    ///< rad/s, of the position and velocity observer.
  double force_filter = 30.0;          ///< rad/s, low-pass of the force that the bias threshold looks at.
  double friction_compensation = 0.9;  ///< Share of the modelled friction that is compensated, 0 to 1.
};

}  // namespace tonus::control
