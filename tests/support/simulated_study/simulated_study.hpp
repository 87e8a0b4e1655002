#pragma once

#include <Eigen/Core>
#include <vector>

#include "rig_agent/in_process/measure.hpp"

/// The published cohort, on the simulated rig.
namespace tonus::simulated {

/// Subjects 0 to 10 of Table IV: stiffness, inertia and the lengths of the arm differ, and joint damping is
/// the row's time constants times the joint stiffness, element by element (hypothesis MS).
inline constexpr std::size_t kCohort = 11;
[[nodiscard]] simulation::SubjectProfile cohort_subject(std::size_t index);

/// tau_s, tau_e, tau_tj (s), zeta_s, zeta_e, zeta_tj of Table IV, a row a subject.
struct TableFourRow {
  Eigen::Vector3d tau;
  double ms_error;  ///< Published fitting error of MS as a share of the largest joint damping.
  Eigen::Vector3d zeta;
  double md_error;
};
[[nodiscard]] const std::vector<TableFourRow>& table_four();

/// Joint damping whose matrix is `elements` = (11, 22, 12), N m s/rad.
[[nodiscard]] simulation::JointImpedance joint_impedance_of(const Eigen::Vector3d& elements);

}  // namespace tonus::simulated
