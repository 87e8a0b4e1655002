#include "analysis_service/impedance/joint_space.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <spdlog/fmt/fmt.h>

namespace tonus::impedance {
namespace {

constexpr int kElements = 3;

bool has_three_constants(Hypothesis h) { return h == Hypothesis::kMS || h == Hypothesis::kMD; }
bool is_scaling(Hypothesis h) { return h == Hypothesis::kSS || h == Hypothesis::kMS; }

/// What the constant multiplies: K_ij, or 2 sqrt(I_ij K_ij) with the sign of K_ij; none where that is
/// imaginary.
std::optional<double> regressor(double I, double K, Hypothesis hypothesis) {
  if (is_scaling(hypothesis)) return K;
  if (I * K < 0.0) return std::nullopt;
  return std::copysign(2.0 * std::sqrt(I * K), K);
}

/// Regression through the origin, of the elements that share one constant.
struct Regression {
  std::vector<double> x;
  std::vector<double> y;

  [[nodiscard]] double squares() const { return std::inner_product(x.begin(), x.end(), x.begin(), 0.0); }
  [[nodiscard]] double constant() const {
    const double xx = squares();
    return xx > 0.0 ? std::inner_product(x.begin(), x.end(), y.begin(), 0.0) / xx : 0.0;
  }
  [[nodiscard]] double residual() const {
    const double slope = constant();
    double sum = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += (y[i] - slope * x[i]) * (y[i] - slope * x[i]);
    return sum;
  }
};

}  // namespace

std::string_view name_of(Hypothesis hypothesis) {
  switch (hypothesis) {
    case Hypothesis::kSS:
      return "SS";
    case Hypothesis::kSD:
      return "SD";
    case Hypothesis::kMS:
      return "MS";
    case Hypothesis::kMD:
      return "MD";
  }
  return "unknown";
}

Result<std::vector<JointMatrices>> joint_matrices(std::span<const PostureImpedance> postures,
                                                  const TwoLink& arm) {
  std::vector<JointMatrices> joints;
  for (const PostureImpedance& posture : postures) {
    if (!arm.reaches(posture.position)) {
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("joint space: posture at {:.4g} m from the shoulder is not allowed; expected "
                              "{:.4g} to {:.4g} m",
                              posture.position.norm(), std::abs(arm.l1 - arm.l2), arm.l1 + arm.l2));
    }
    const Eigen::Matrix2d J = arm.jacobian(arm.angles_at(posture.position));
    joints.push_back({to_joints(posture.impedance.M, J), to_joints(posture.impedance.B, J),
                      to_joints(posture.impedance.K, J), J});
  }
  return joints;
}

Eigen::Vector3d joint_elements(const Eigen::Matrix2d& R) {
  return {R(0, 0), R(1, 1), 0.5 * (R(0, 1) + R(1, 0))};
}

Result<HypothesisFit> fit_hypothesis(std::span<const JointMatrices> postures, Hypothesis hypothesis) {
  const int constants = has_three_constants(hypothesis) ? kElements : 1;
  HypothesisFit fit;
  fit.hypothesis = hypothesis;
  Regression regressions[kElements];
  double largest_damping = 0.0;
  for (const JointMatrices& joint : postures) {
    const Eigen::Vector3d I = joint_elements(joint.I);
    const Eigen::Vector3d B = joint_elements(joint.B);
    const Eigen::Vector3d K = joint_elements(joint.K);
    largest_damping = std::max(largest_damping, B.cwiseAbs().maxCoeff());
    for (int element = 0; element < kElements; ++element) {
      const auto x = regressor(I[element], K[element], hypothesis);
      if (!x) {
        ++fit.left_out;
        continue;
      }
      Regression& regression = regressions[constants == 1 ? 0 : element];
      regression.x.push_back(*x);
      regression.y.push_back(B[element]);
    }
  }
  fit.constants.resize(constants);
  fit.std.resize(constants);
  double residual = 0.0;
  std::size_t used = 0;
  for (int i = 0; i < constants; ++i) {
    const Regression& regression = regressions[i];
    const std::size_t count = regression.x.size();
    if (count < 2) {
      return fail(
          ErrorCode::kInvalidArgument,
          fmt::format("hypothesis {}: {} elements for constant {} are not allowed; expected 2 or more",
                      name_of(hypothesis), count, i + 1));
    }
    fit.constants[i] = regression.constant();
    fit.std[i] = std::sqrt(regression.residual() / (static_cast<double>(count - 1) * regression.squares()));
    residual += regression.residual();
    used += count;
  }
  fit.error = largest_damping > 0.0 ? std::sqrt(residual / static_cast<double>(used)) / largest_damping : 0.0;

  for (const JointMatrices& joint : postures) {
    const Eigen::Vector3d I = joint_elements(joint.I);
    const Eigen::Vector3d K = joint_elements(joint.K);
    Eigen::Vector3d B;
    for (int element = 0; element < kElements; ++element) {
      B[element] = fit.constants[constants == 1 ? 0 : element] *
                   regressor(I[element], K[element], hypothesis).value_or(0.0);
    }
    Eigen::Matrix2d matrix;
    matrix << B[0], B[2], B[2], B[1];
    fit.damping.push_back(to_endpoint(matrix, joint.jacobian));
  }
  return fit;
}

}  // namespace tonus::impedance
