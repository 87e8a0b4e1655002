#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "analysis_service/impedance/arm_model.hpp"
#include "services/core/result.hpp"

namespace tonus::impedance {

/// A subject's segments as measured. A radius that is not known follows from the mass found and kLimbDensity.
struct LimbSize {
  double upper_arm_length = 0.0;           ///< m.
  double forearm_length = 0.0;             ///< m.
  std::optional<double> upper_arm_radius;  ///< m.
  std::optional<double> forearm_radius;    ///< m.
};

/// An identified Cartesian mass matrix (kg, in S) at a hand position (m, in S).
struct PostureMass {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Matrix2d M = Eigen::Matrix2d::Zero();
  bool is_used = true;  ///< False for the proximal posture, whose data skew the fit (published).
};

/// Link masses m1 (upper arm), m2 (forearm with hand) implied by the mass matrices (Table I).
struct LinkMasses {
  Eigen::Vector2d mass = Eigen::Vector2d::Zero();  ///< kg.
  Eigen::Vector2d std = Eigen::Vector2d::Zero();   ///< kg, one standard deviation, from the residual.
  double sigma = 0.0;                              ///< kg, root mean square residual of the elements used.
  ArmModel arm;                                    ///< The two cylinders found.
  std::vector<Eigen::Matrix2d>
      modelled;  ///< kg, J^-T I J^-1 of these masses at every posture, used or not (Fig. 5).
};

/// Least squares of all elements of J^-T I(t) J^-1 (31a) on those of the identified matrices; I(t) is linear
/// in m1, m2 for fixed radii. Radii from the masses are found by repeating the fit until they stand still.
/// Errors (kInvalidArgument): a length not positive, a posture out of reach, no posture to use.
[[nodiscard]] Result<LinkMasses> fit_link_masses(std::span<const PostureMass> postures, const LimbSize& size);

}  // namespace tonus::impedance
