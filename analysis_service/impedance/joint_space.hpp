#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "analysis_service/impedance/arm_model.hpp"
#include "services/core/result.hpp"
#include "services/mechanics/two_link.hpp"

namespace tonus::impedance {

/// Identified impedance at a hand position (m, in S).
struct PostureImpedance {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  CartesianImpedance impedance;
};

/// I (kg m2), B (N m s/rad), K (N m/rad) of the joints by (17), and their Jacobian (m/rad).
struct JointMatrices {
  Eigen::Matrix2d I = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d B = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d K = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d jacobian = Eigen::Matrix2d::Identity();
};

/// (17) at each posture. Error kInvalidArgument: a posture out of the arm's reach.
[[nodiscard]] Result<std::vector<JointMatrices>> joint_matrices(std::span<const PostureImpedance> postures,
                                                                const TwoLink& arm);

/// Shoulder (11), elbow (22) and two-joint element of a joint matrix, the last as mean of 12 and 21.
[[nodiscard]] Eigen::Vector3d joint_elements(const Eigen::Matrix2d& R);

/// How joint damping follows joint stiffness and inertia (Tables III, IV).
enum class Hypothesis : std::uint8_t {
  kSS,  ///< B_ij = tau K_ij, one constant.
  kSD,  ///< B_ij = 2 zeta sqrt(I_ij K_ij), one constant.
  kMS,  ///< As kSS with constants for shoulder, elbow and two-joint element.
  kMD,  ///< As kSD with three constants.
};
inline constexpr Hypothesis kHypotheses[] = {Hypothesis::kSS, Hypothesis::kSD, Hypothesis::kMS,
                                             Hypothesis::kMD};

/// "SS", "SD", "MS", "MD".
[[nodiscard]] std::string_view name_of(Hypothesis hypothesis);

/// Least-squares fit of one hypothesis to a subject.
struct HypothesisFit {
  Hypothesis hypothesis = Hypothesis::kSS;
  Eigen::VectorXd constants;  ///< s (tau) or 1 (zeta): one, or shoulder, elbow, two-joint.
  Eigen::VectorXd std;        ///< One standard deviation each, from the residual.
  double error =
      0.0;  ///< Root mean square fitting error over the largest joint damping: the tables' % error.
  std::size_t left_out = 0;  ///< Elements left out because I_ij K_ij is negative.
  std::vector<Eigen::Matrix2d>
      damping;  ///< N s/m, the Cartesian damping it reconstructs at each posture (Figs 8, 9).
};

/// Fits a hypothesis over all postures and the three elements. The sign of sqrt(I_12 K_12) follows K_12; an
/// element with a negative product is left out, counted, and 0 in the reconstruction. Error kInvalidArgument:
/// no postures, or fewer elements than constants and one.
[[nodiscard]] Result<HypothesisFit> fit_hypothesis(std::span<const JointMatrices> postures,
                                                   Hypothesis hypothesis);

}  // namespace tonus::impedance
