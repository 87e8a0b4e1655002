#include "analysis_service/impedance/ellipse.hpp"

#include <cmath>
#include <numbers>

namespace tonus::impedance {
namespace {

/// (7a): l1, l2. The root is the distance of (s1 - s3, 2 s2) from 0, which equals the printed one and never
/// takes the root of a negative number.
Eigen::Vector2d eigenvalues_of_symmetric(const Eigen::Matrix2d& Zs) {
  const double sum = Zs(0, 0) + Zs(1, 1);
  const double root = std::hypot(Zs(0, 0) - Zs(1, 1), 2.0 * Zs(0, 1));
  const double major = 0.5 * (sum + root);
  // For a positive definite matrix, l1 = det / l2 keeps the digits that sum - root cancels.
  const double minor = sum > 0.0 ? (Zs(0, 0) * Zs(1, 1) - Zs(0, 1) * Zs(0, 1)) / major : 0.5 * (sum - root);
  return {minor, major};
}

}  // namespace

Eigen::Matrix2d symmetric_part(const Eigen::Matrix2d& Z) { return 0.5 * (Z + Z.transpose()); }
Eigen::Matrix2d antisymmetric_part(const Eigen::Matrix2d& Z) { return 0.5 * (Z - Z.transpose()); }

std::string_view not_an_ellipse(const Eigen::Matrix2d& Z) {
  if (!Z.allFinite()) return "not finite";
  return eigenvalues_of_symmetric(symmetric_part(Z))[0] > 0.0 ? "ok" : "not positive definite";
}

std::optional<Ellipse> ellipse_of(const Eigen::Matrix2d& Z) {
  if (not_an_ellipse(Z) != "ok") return std::nullopt;
  const Eigen::Matrix2d Zs = symmetric_part(Z);
  const Eigen::Vector2d l = eigenvalues_of_symmetric(Zs);
  Ellipse ellipse;
  ellipse.minor = l[0];
  ellipse.major = l[1];
  ellipse.size = std::numbers::pi * l[0] * l[1];
  ellipse.shape = l[1] / l[0];
  ellipse.is_circle = l[1] - l[0] <= 1e-9 * l[1];
  if (!ellipse.is_circle) {
    ellipse.orientation = rotation_between(0.0, 0.5 * std::atan2(2.0 * Zs(0, 1), Zs(0, 0) - Zs(1, 1)));
  }
  return ellipse;
}

std::optional<Curl> curl_of(const Eigen::Matrix2d& Z) {
  if (not_an_ellipse(Z) != "ok") return std::nullopt;
  const Eigen::Vector2d l = eigenvalues_of_symmetric(symmetric_part(Z));
  const double za = std::abs(antisymmetric_part(Z)(0, 1));
  return Curl{za / l[1], za / l[0], za / std::sqrt(l[0] * l[1])};
}

double rotation_between(double from, double to) {
  const double turn = std::remainder(to - from, std::numbers::pi);  // [-pi/2, pi/2]
  return turn <= -0.5 * std::numbers::pi ? 0.5 * std::numbers::pi : turn;
}

}  // namespace tonus::impedance
