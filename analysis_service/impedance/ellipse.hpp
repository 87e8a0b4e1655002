#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>

namespace tonus::impedance {

/// Zs and Za of (5): Z = Zs + Za.
[[nodiscard]] Eigen::Matrix2d symmetric_part(const Eigen::Matrix2d& Z);
[[nodiscard]] Eigen::Matrix2d antisymmetric_part(const Eigen::Matrix2d& Z);

/// Ellipse of the symmetric part of an impedance matrix (6)-(7): the locus of the restoring force for a unit
/// displacement turned through 360 deg.
struct Ellipse {
  double minor = 0.0;  ///< l1 of (7a), the smaller eigenvalue; the matrix's unit.
  double major = 0.0;  ///< l2 of (7a).
  double size = 0.0;   ///< A = pi l1 l2 (7b), unit squared.
  double shape = 1.0;  ///< R = l2 / l1 (7c).
  double orientation =
      0.0;  ///< rad, in (-pi/2, pi/2]: direction of l2's eigenvector from +x (7d). 0 in a circle.
  bool is_circle = false;  ///< l2 - l1 <= 1e-9 l2: the orientation is undefined.
};

/// The ellipse, or none where Zs is not positive definite (then not_an_ellipse() says why). (7d) is evaluated
/// as atan2(2 s2, s1 - s3)/2, which equals it and is defined at s2 = 0 too.
[[nodiscard]] std::optional<Ellipse> ellipse_of(const Eigen::Matrix2d& Z);

/// "ok", "not finite" or "not positive definite": why ellipse_of gives none.
[[nodiscard]] std::string_view not_an_ellipse(const Eigen::Matrix2d& Z);

/// Rotational part of the field as shares of the eigenvalues of Zs (9), za = |Za(1,2)|.
struct Curl {
  double p_min = 0.0;   ///< za / l2.
  double p_max = 0.0;   ///< za / l1.
  double p_mean = 0.0;  ///< sqrt(p_min p_max).
};

/// The curl, or none where Zs is not positive definite.
[[nodiscard]] std::optional<Curl> curl_of(const Eigen::Matrix2d& Z);

/// Angle from orientation `from` to `to` (rad) of two ellipses, in (-pi/2, pi/2]: positive is
/// counter-clockwise.
[[nodiscard]] double rotation_between(double from, double to);

}  // namespace tonus::impedance
