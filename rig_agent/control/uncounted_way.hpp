#pragma once

#include <Eigen/Core>
#include <array>

#include "rig_agent/control/safety_limits.hpp"
#include "services/mechanics/rig_geometry.hpp"
#include "services/mechanics/two_link_dynamics.hpp"

namespace tonus::control {

/// Whether a joint whose encoder does not count should have turned.
///
/// While joint k stands still, the torque u_k (Servo::unexplained_torque()) that its rest would need beside
/// those that were given and felt can be friction, an error of the force or of the motor's torque; what is
/// more turns it:
///
///     w_k' = (|u_k| - a_k) / H_kk,    x_k' = w_k,    a_k = share of the limit + 3 Coulomb's + share of the
///     load
///
/// from its last count on, anew whenever u_k is less than a_k or changes its sign. The encoder stands still
/// where x_k is more than a way that no error of the model leaves: some counts, and a share of what the other
/// joint has turned meanwhile, whose acceleration acts on this one.
///
/// All methods are REALTIME.
class UncountedWay {
 public:
  /// `period` in s.
  UncountedWay(const SafetyLimits& limits, const JointFriction& friction, const RigGeometry& geometry,
               double period) noexcept;

  void begin_trial(const std::array<double, 2>& counts) noexcept;

  /// Takes the encoders' counts, u and the load of both joints (N m), and their inertias (kg m2).
  [[nodiscard]] bool check(const std::array<double, 2>& counts, const Eigen::Vector2d& unexplained,
                           const Eigen::Vector2d& load, const Eigen::Vector2d& inertia) noexcept;

 private:
  struct Joint {
    double count = 0.0;   // as last seen to change
    double torque = 0.0;  // N m, the last one beyond what is allowed; 0 for none
    double rate = 0.0;    // rad/s
    double way = 0.0;     // rad
    double lowest = 0.0;  // counts of the other joint meanwhile
    double highest = 0.0;
  };

  [[nodiscard]] double turned_meanwhile(std::size_t joint) const noexcept;

  const double period_;
  const double allowed_;  // N m
  const Eigen::Vector2d friction_;
  const Eigen::Vector2d radians_per_count_;
  std::array<Joint, 2> joints_{};
};

}  // namespace tonus::control
