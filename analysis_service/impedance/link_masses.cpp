#include "analysis_service/impedance/link_masses.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <spdlog/fmt/fmt.h>

namespace tonus::impedance {
namespace {

/// Cartesian mass matrix of the arm at a position.
Eigen::Matrix2d mass_matrix(const ArmModel& arm, const Eigen::Vector2d& position) {
  const Eigen::Vector2d angles = arm.links().angles_at(position);
  return to_endpoint(arm.inertia(angles), arm.links().jacobian(angles));
}

ArmModel with_masses(ArmModel arm, double m1, double m2) {
  arm.upper_arm.mass = m1;
  arm.forearm.mass = m2;
  return arm;
}

struct Fit {
  Eigen::Vector2d mass;
  Eigen::Vector2d std;
  double sigma;
};

/// Linear in m1, m2: the columns are the matrices of either link with a mass of 1 kg.
Fit fit_for_radii(std::span<const PostureMass> postures, const ArmModel& arm) {
  const auto used = std::ranges::count_if(postures, &PostureMass::is_used);
  Eigen::MatrixX2d A(4 * used, 2);
  Eigen::VectorXd y(4 * used);
  Eigen::Index row = 0;
  for (const PostureMass& posture : postures) {
    if (!posture.is_used) continue;
    A.block<4, 1>(row, 0) = mass_matrix(with_masses(arm, 1.0, 0.0), posture.position).reshaped();
    A.block<4, 1>(row, 1) = mass_matrix(with_masses(arm, 0.0, 1.0), posture.position).reshaped();
    y.segment<4>(row) = posture.M.reshaped();
    row += 4;
  }
  Fit fit;
  fit.mass = A.colPivHouseholderQr().solve(y);
  const double residual = (y - A * fit.mass).squaredNorm();
  const Eigen::Matrix2d inverse = (A.transpose() * A).inverse();
  fit.std = (residual / static_cast<double>(y.size() - 2) * inverse.diagonal()).cwiseSqrt();
  fit.sigma = std::sqrt(residual / static_cast<double>(y.size()));
  return fit;
}

}  // namespace

Result<LinkMasses> fit_link_masses(std::span<const PostureMass> postures, const LimbSize& size) {
  ArmModel arm{{0.0, size.upper_arm_length, size.upper_arm_radius.value_or(0.0)},
               {0.0, size.forearm_length, size.forearm_radius.value_or(0.0)}};
  for (const double length : {size.upper_arm_length, size.forearm_length}) {
    if (!(length > 0.0)) {
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("link masses: length: {} m is not allowed; expected more than 0 m", length));
    }
  }
  if (std::ranges::none_of(postures, &PostureMass::is_used)) {
    return fail(ErrorCode::kInvalidArgument,
                "link masses: 0 postures to fit are not allowed; expected 1 or more");
  }
  for (const PostureMass& posture : postures) {
    if (!arm.links().reaches(posture.position)) {
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("link masses: posture at {:.4g} m from the shoulder is not allowed; expected "
                              "{:.4g} to {:.4g} m",
                              posture.position.norm(), std::abs(arm.links().l1 - arm.links().l2),
                              arm.links().l1 + arm.links().l2));
    }
  }
  constexpr int kMostPasses = 50;
  Fit fit = fit_for_radii(postures, arm);
  for (int pass = 0; pass < kMostPasses && !(size.upper_arm_radius && size.forearm_radius); ++pass) {
    const Eigen::Vector2d before = fit.mass;
    if (!size.upper_arm_radius) {
      arm.upper_arm.radius = radius_from_mass(std::max(fit.mass[0], 0.0), arm.upper_arm.length);
    }
    if (!size.forearm_radius)
      arm.forearm.radius = radius_from_mass(std::max(fit.mass[1], 0.0), arm.forearm.length);
    fit = fit_for_radii(postures, arm);
    if ((fit.mass - before).norm() <= 1e-12 * fit.mass.norm()) break;
  }
  LinkMasses result{fit.mass, fit.std, fit.sigma, with_masses(arm, fit.mass[0], fit.mass[1]), {}};
  for (const PostureMass& posture : postures)
    result.modelled.push_back(mass_matrix(result.arm, posture.position));
  return result;
}

}  // namespace tonus::impedance
