#pragma once

#include <Eigen/Core>

#include "services/mechanics/two_link_dynamics.hpp"
#include "services/simulation/instruction.hpp"
#include "services/simulation/subject_profile.hpp"

namespace tonus::simulation {

/// Impedance of the hand in the shoulder frame S: F = M x" + B x' + K (x - X0), F on the arm, x from the
/// posture.
struct CartesianImpedance {
  Eigen::Matrix2d mass = Eigen::Matrix2d::Zero();           ///< kg.
  Eigen::Matrix2d damping = Eigen::Matrix2d::Zero();        ///< N s/m.
  Eigen::Matrix2d stiffness = Eigen::Matrix2d::Zero();      ///< N/m.
  Eigen::Vector2d spring_centre = Eigen::Vector2d::Zero();  ///< m, from the posture.
};

/// Inertia of two uniform cylinders: m (l^2/3 + r^2/4) about an end, m l/2 the first moment; equation (31).
[[nodiscard]] control::TwoLinkInertia cylinder_inertia(const SubjectProfile& subject);

/// The forward model (21)-(31), closed form: joint matrices to the hand by the Jacobian J at posture p_SE
/// (m), Z = J^-T Z_joint J^-1, the effects of a living arm left out. The spring centre is at the posture,
/// because the simulated subject's equilibrium is there. For tests and for showing an estimate beside the
/// truth in simulation, and for nothing else. With what the subject adds under an instruction.
[[nodiscard]] CartesianImpedance true_impedance(const SubjectProfile& subject, const Eigen::Vector2d& p_SE,
                                                const Instruction& instruction = {});

}  // namespace tonus::simulation
