#pragma once

#include <Eigen/Core>

#include "rig_agent/control/observer_lag.hpp"

namespace tonus::control {

/// Whether the damping of the safe state takes energy out of the handle, as damping must.
///
/// Damping and friction can only take from what the motion holds, so that with the joint rates q' (rad/s) as
/// measured, the mass matrix H (kg m2) and the joint torques J^T f (N m) of the force f on the arm
///
///     B = q'^T H q' / 2 + integral of q' . J^T f dt      (J; the second is what the hand was given)
///
/// never rises. Where it rises from its lowest by more than kShare of the largest kinetic energy so far and
/// kFloor, the torque has driven what it claims to damp: an encoder counts backwards, or a motor turns the
/// wrong way. From then on damping is not to be given until begin(). A hand that pushes gives its energy
/// through the force sensor and does not count, as long as the sensor is right.
///
/// The observer answers accelerations that it did not predict late (ObserverLag); so does the torque of the
/// force here, from zero at the start on as the observer, and the balance holds for a motion that lags. The
/// first kSettling seconds, in which the observer forgets what it was told before, compare nothing. The
/// torque that is given is no part of B: a motor that gives less than it is asked for damps less, and is no
/// reason to stop.
///
/// All methods are REALTIME.
class DampingWatch {
 public:
  static constexpr double kSettling = 0.1;  ///< s.
  static constexpr double kShare = 0.3;     ///< Of the largest kinetic energy; inertia and force may be off.
  static constexpr double kFloor = 0.003;   ///< J; 2.7 cm/s at a handle of 8 kg.

  /// rad/s, s.
  DampingWatch(double observer_frequency, double period) noexcept;

  /// The safe state begins anew: damping is believed.
  void begin() noexcept;
  /// The observer starts anew: so does the balance. What was found stays.
  void restart() noexcept;

  /// One cycle under damping. False from the cycle on in which the damping was found to drive.
  [[nodiscard]] bool takes_energy(const Eigen::Matrix2d& mass_matrix, const Eigen::Vector2d& rates,
                                  const Eigen::Vector2d& load) noexcept;

 private:
  const double period_;
  const int settling_cycles_;

  bool has_driven_ = false;
  int cycles_ = 0;        // Since the start, up to settling_cycles_.
  ObserverLag<1> load_;   // N m.
  double given_ = 0.0;    // J, to the hand.
  double largest_ = 0.0;  // J, of the kinetic energy.
  double lowest_ = 0.0;   // J, of B.
};

}  // namespace tonus::control
