#include "tests/support/simulated_study/simulated_study.hpp"

namespace tonus::simulated {

simulation::SubjectProfile cohort_subject(std::size_t index) {
  // Arms and stiffness differ by steps that share no factor with the number of subjects.
  const auto spread = [index](std::size_t stride) {
    return static_cast<double>((stride * index) % kCohort) / (kCohort - 1) - 0.5;  // -0.5 to 0.5
  };
  simulation::SubjectProfile subject;
  subject.links = {0.31 + 0.04 * spread(3), 0.34 + 0.04 * spread(5)};
  subject.link_masses = {2.0 + 0.8 * spread(2), 1.5 + 0.5 * spread(7)};
  const double stiffness = 1.0 + 0.6 * spread(4);
  subject.stiffness = {22.0 * stiffness, 17.0 * stiffness, 8.0 * stiffness};
  const Eigen::Matrix2d K = subject.stiffness.matrix();
  const Eigen::Vector3d elements(K(0, 0), K(1, 1), K(0, 1));
  subject.damping = joint_impedance_of(table_four().at(index).tau.cwiseProduct(elements));
  return subject;
}

const std::vector<TableFourRow>& table_four() {
  static const std::vector<TableFourRow> rows = {{{0.067, 0.040, 0.039}, 0.17, {0.254, 0.261, 0.176}, 0.12},
                                                 {{0.062, 0.046, 0.021}, 0.11, {0.252, 0.284, 0.104}, 0.07},
                                                 {{0.037, 0.013, 0.012}, 0.21, {0.186, 0.097, 0.063}, 0.19},
                                                 {{0.082, 0.050, 0.045}, 0.13, {0.272, 0.295, 0.196}, 0.12},
                                                 {{0.178, 0.108, 0.078}, 0.10, {0.507, 0.553, 0.243}, 0.09},
                                                 {{0.246, 0.214, 0.177}, 0.25, {0.582, 0.977, 0.512}, 0.17},
                                                 {{0.067, 0.082, 0.053}, 0.20, {0.201, 0.427, 0.143}, 0.17},
                                                 {{0.019, 0.042, 0.010}, 0.30, {0.105, 0.402, 0.067}, 0.22},
                                                 {{0.087, 0.069, 0.027}, 0.18, {0.249, 0.349, 0.089}, 0.15},
                                                 {{0.030, 0.020, 0.004}, 0.33, {0.127, 0.135, 0.015}, 0.27},
                                                 {{0.010, 0.013, 0.008}, 0.29, {0.067, 0.139, 0.063}, 0.23}};
  return rows;
}

simulation::JointImpedance joint_impedance_of(const Eigen::Vector3d& elements) {
  return {elements[0] - elements[2], elements[1] - elements[2], elements[2]};
}

}  // namespace tonus::simulated
