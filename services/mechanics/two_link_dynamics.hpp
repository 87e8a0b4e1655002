#pragma once

#include <Eigen/Core>
#include <cmath>

#include "services/mechanics/two_link.hpp"

namespace tonus::control {

/// Rigid-body dynamics of a planar two-link chain in the horizontal plane (no gravity):
///
///     H(q) q'' + c(q, q') = tau + J(q)' f
///
///     H = [ i + o + 2 k cos q2   o + k cos q2 ]        c = k sin q2 [ -(2 q1' + q2') q2' ]
///         [ o + k cos q2         o            ]                     [  q1'^2            ]
///
/// i = `inner`:    inertia of all that turns with link 1, about joint 1, with the mass of link 2 taken at the
/// elbow; o = `outer`:    inertia of all that turns with link 2 (its motor's rotor too), about the elbow; k =
/// `coupling`: mass of link 2 times its centre's distance from the elbow times l1. All in kg m2. Used for the
/// manipulandum by the control law and by the plant, and for the arm by the plant. All functions are pure,
/// allocate nothing and may be called from a realtime thread.
struct TwoLinkInertia {
  double inner = 0.0;
  double outer = 0.0;
  double coupling = 0.0;

  /// H for given cos q2.
  [[nodiscard]] Eigen::Matrix2d mass_matrix(double cos_q2) const {
    const double off = outer + coupling * cos_q2;
    Eigen::Matrix2d h;
    h << inner + outer + 2.0 * coupling * cos_q2, off, off, outer;
    return h;
  }

  /// c for given sin q2 and joint rates (rad/s), N m.
  [[nodiscard]] Eigen::Vector2d coriolis(double sin_q2, const Eigen::Vector2d& rates) const {
    const double ks = coupling * sin_q2;
    return {-ks * (2.0 * rates[0] + rates[1]) * rates[1], ks * rates[0] * rates[0]};
  }
};

/// Position, Jacobian and mass matrix of one posture, from one evaluation of the sines: for the realtime loop
/// and the integrator, where TwoLink's separate functions would evaluate them again and again.
struct TwoLinkState {
  Eigen::Vector2d point;     ///< Endpoint, m.
  Eigen::Matrix2d jacobian;  ///< m/rad.
  double sin_q2 = 0.0;
  double cos_q2 = 1.0;
  double sin_q12 = 0.0;  ///< Of q1 + q2.
  double cos_q12 = 1.0;

  double sin_q1 = 0.0;
  double cos_q1 = 1.0;

  TwoLinkState(const TwoLink& links, const Eigen::Vector2d& q)
      : sin_q12(std::sin(q[0] + q[1])),
        cos_q12(std::cos(q[0] + q[1])),
        sin_q1(std::sin(q[0])),
        cos_q1(std::cos(q[0])) {
    follow(links);
  }

  /// The state at q + `step`, from this one at q without a sine: sines and cosines are turned by the step's,
  /// of which the series to the sixth order leaves out less than rounding does (2e-18) for steps of at most
  /// kLongestStep. Longer ones, and those that are no numbers, are evaluated anew from `q`.
  static constexpr double kLongestStep = 0.01;  // rad
  [[nodiscard]] TwoLinkState moved_by(const TwoLink& links, const Eigen::Vector2d& q,
                                      const Eigen::Vector2d& step) const {
    const double step12 = step[0] + step[1];
    if (!(std::abs(step[0]) <= kLongestStep && std::abs(step12) <= kLongestStep)) return {links, q + step};
    TwoLinkState moved = *this;
    turn(moved.sin_q1, moved.cos_q1, step[0]);
    turn(moved.sin_q12, moved.cos_q12, step12);
    moved.follow(links);
    return moved;
  }

  /// dJ/dt times the joint rates, m/s2.
  [[nodiscard]] Eigen::Vector2d jacobian_rate_times_rates(const Eigen::Vector2d& rates) const {
    const double w1 = rates[0];
    const double w12 = rates[0] + rates[1];
    const double x2 = jacobian(1, 1);
    const double y2 = -jacobian(0, 1);
    const double x1 = point.x() - x2;
    const double y1 = point.y() - y2;
    return {-x1 * w1 * w1 - x2 * w12 * w12, -y1 * w1 * w1 - y2 * w12 * w12};
  }

 private:
  /// What follows from the sines and cosines of q1 and q1 + q2.
  void follow(const TwoLink& links) {
    sin_q2 = sin_q12 * cos_q1 - cos_q12 * sin_q1;
    cos_q2 = cos_q12 * cos_q1 + sin_q12 * sin_q1;
    const double x2 = links.l2 * cos_q12;
    const double y2 = links.l2 * sin_q12;
    point = {links.l1 * cos_q1 + x2, links.l1 * sin_q1 + y2};
    jacobian << -point.y(), -y2, point.x(), x2;
  }

  /// sin(a) and cos(a) to those of a + d, as sin(a) + (sin(a) (cos(d) - 1) + cos(a) sin(d)) and likewise.
  static void turn(double& sine, double& cosine, double d) {
    const double d2 = d * d;
    const double sin_d = d * (1.0 - d2 * (1.0 / 6.0 - d2 * (1.0 / 120.0)));
    const double less = -d2 * (0.5 - d2 * (1.0 / 24.0 - d2 * (1.0 / 720.0)));  // cos(d) - 1
    const double s = sine;
    sine += s * less + cosine * sin_d;
    cosine += cosine * less - s * sin_d;
  }
};

/// Inverse of a 2x2 matrix; the caller knows that it is regular.
[[nodiscard]] inline Eigen::Matrix2d inverse(const Eigen::Matrix2d& m) {
  const double scale = 1.0 / (m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0));
  Eigen::Matrix2d inv;
  inv << scale * m(1, 1), -scale * m(0, 1), -scale * m(1, 0), scale * m(0, 0);
  return inv;
}

/// Joint friction, N m, opposing the motion: viscous b w plus Coulomb t w / sqrt(w^2 + w0^2). The smooth sign
/// keeps the equation of motion integrable; below w0 (rad/s) the joint creeps where a real one would stick.
struct JointFriction {
  Eigen::Vector2d viscous = Eigen::Vector2d::Zero();  ///< N m s/rad.
  Eigen::Vector2d coulomb = Eigen::Vector2d::Zero();  ///< N m.
  double smoothing = 0.02;                            ///< w0, rad/s.

  [[nodiscard]] Eigen::Vector2d torque(const Eigen::Vector2d& rates) const {
    const double w0 = smoothing * smoothing;
    return {rates[0] * (viscous[0] + coulomb[0] / std::sqrt(rates[0] * rates[0] + w0)),
            rates[1] * (viscous[1] + coulomb[1] / std::sqrt(rates[1] * rates[1] + w0))};
  }
};

/// What the control law knows of the manipulandum. The default is that of deploy/profiles/default.toml.
struct ManipulandumModel {
  TwoLinkInertia inertia{0.8135, 0.92554, 0.07875};
  JointFriction friction;
};

}  // namespace tonus::control
