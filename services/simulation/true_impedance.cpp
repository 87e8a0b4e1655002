#include "services/simulation/true_impedance.hpp"

namespace tonus::simulation {

control::TwoLinkInertia cylinder_inertia(const SubjectProfile& subject) {
  const double l1 = subject.links.l1;
  const double l2 = subject.links.l2;
  const Eigen::Vector2d& m = subject.link_masses;
  const Eigen::Vector2d& r = subject.link_radii;
  const double about_shoulder = m[0] * (l1 * l1 / 3.0 + r[0] * r[0] / 4.0);
  const double about_elbow = m[1] * (l2 * l2 / 3.0 + r[1] * r[1] / 4.0);
  return {about_shoulder + m[1] * l1 * l1, about_elbow, m[1] * l1 * 0.5 * l2};
}

CartesianImpedance true_impedance(const SubjectProfile& subject, const Eigen::Vector2d& p_SE,
                                  const Instruction& instruction) {
  const AddedImpedance added = added_impedance(subject, instruction, subject.links.angles_at(p_SE));
  const control::TwoLinkState arm(subject.links, subject.links.angles_at(p_SE));
  const Eigen::Matrix2d inverse_jacobian = control::inverse(arm.jacobian);
  const auto to_hand = [&](const Eigen::Matrix2d& joint) -> Eigen::Matrix2d {
    return inverse_jacobian.transpose() * joint * inverse_jacobian;
  };
  CartesianImpedance impedance;
  impedance.mass = to_hand(cylinder_inertia(subject).mass_matrix(arm.cos_q2));
  impedance.damping = to_hand(subject.damping.matrix() + added.damping);
  impedance.stiffness = to_hand(subject.stiffness.matrix() + added.stiffness);
  return impedance;
}

}  // namespace tonus::simulation
