#include "analysis_service/impedance/joint_space.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "tests/support/impedance/linear_rig.hpp"

namespace tonus::impedance::test {
namespace {

constexpr JointImpedance kStiffness{20.0, 15.0, 6.0};

/// A subject whose stiffness varies over postures and whose joint damping is made by `damping(I, K)`.
template <typename Damping>
std::vector<JointMatrices> subject(const Damping& damping) {
  std::vector<PostureImpedance> postures;
  double scale = 0.8;
  for (const auto& position : published_positions()) {
    const ArmModel arm = typical_arm();
    const Eigen::Vector2d angles = arm.links().angles_at(position);
    const Eigen::Matrix2d J = arm.links().jacobian(angles);
    const Eigen::Matrix2d I = arm.inertia(angles);
    const Eigen::Matrix2d K = scale * kStiffness.matrix();
    postures.push_back({position, {to_endpoint(I, J), to_endpoint(damping(I, K), J), to_endpoint(K, J)}});
    scale += 0.1;
  }
  return joint_matrices(postures, typical_arm().links()).value();
}

Eigen::Matrix2d symmetric(double shoulder, double elbow, double two_joint) {
  Eigen::Matrix2d matrix;
  matrix << shoulder, two_joint, two_joint, elbow;
  return matrix;
}

/// tables.toml, table4, all subjects: tau_s, tau_e, tau_tj, zeta_s, zeta_e, zeta_tj.
constexpr double kTableFour[][6] = {
    {0.067, 0.040, 0.039, 0.254, 0.261, 0.176}, {0.062, 0.046, 0.021, 0.252, 0.284, 0.104},
    {0.037, 0.013, 0.012, 0.186, 0.097, 0.063}, {0.082, 0.050, 0.045, 0.272, 0.295, 0.196},
    {0.178, 0.108, 0.078, 0.507, 0.553, 0.243}, {0.246, 0.214, 0.177, 0.582, 0.977, 0.512},
    {0.067, 0.082, 0.053, 0.201, 0.427, 0.143}, {0.019, 0.042, 0.010, 0.105, 0.402, 0.067},
    {0.087, 0.069, 0.027, 0.249, 0.349, 0.089}, {0.030, 0.020, 0.004, 0.127, 0.135, 0.015},
    {0.010, 0.013, 0.008, 0.067, 0.139, 0.063}};

/// tables.toml, table3: tau, zeta.
constexpr double kTableThree[][2] = {{0.056, 0.25}, {0.057, 0.25}, {0.026, 0.17}, {0.068, 0.27},
                                     {0.151, 0.51}, {0.227, 0.62}, {0.071, 0.23}, {0.026, 0.14},
                                     {0.077, 0.25}, {0.025, 0.12}, {0.011, 0.08}};

TEST(JointSpace, RecoversTheJointMatricesBehindTheEndpoint) {
  const auto joints =
      subject([](const Eigen::Matrix2d&, const Eigen::Matrix2d& K) -> Eigen::Matrix2d { return 0.05 * K; });
  EXPECT_LT((joints[2].K - kStiffness.matrix()).norm(), 1e-10);  // The third posture's scale is 1.
  EXPECT_LT((joints[0].B - 0.05 * 0.8 * kStiffness.matrix()).norm(), 1e-10);
}

TEST(JointSpace, RecoversTableThreesConstantsFromExactMatrices) {
  for (const auto& [tau, zeta] : kTableThree) {
    const double t = tau;
    const auto scaled =
        subject([t](const Eigen::Matrix2d&, const Eigen::Matrix2d& K) -> Eigen::Matrix2d { return t * K; });
    const HypothesisFit ss = fit_hypothesis(scaled, Hypothesis::kSS).value();
    EXPECT_NEAR(ss.constants[0], tau, 1e-12);
    EXPECT_LT(ss.error, 1e-9);
    EXPECT_LT(ss.std[0], 1e-9);
    const double z = zeta;
    const auto ratio = subject([z](const Eigen::Matrix2d& I, const Eigen::Matrix2d& K) -> Eigen::Matrix2d {
      return 2.0 * z * (I.cwiseProduct(K)).cwiseSqrt();
    });
    EXPECT_NEAR(fit_hypothesis(ratio, Hypothesis::kSD)->constants[0], zeta, 1e-12);
  }
}

TEST(JointSpace, RecoversTableFoursConstantsFromExactMatrices) {
  for (const auto& row : kTableFour) {
    const auto scaled = subject([&row](const Eigen::Matrix2d&, const Eigen::Matrix2d& K) {
      return symmetric(row[0] * K(0, 0), row[1] * K(1, 1), row[2] * K(0, 1));
    });
    const HypothesisFit ms = fit_hypothesis(scaled, Hypothesis::kMS).value();
    const auto ratio = subject([&row](const Eigen::Matrix2d& I, const Eigen::Matrix2d& K) {
      const Eigen::Matrix2d root = I.cwiseProduct(K).cwiseSqrt();
      return symmetric(2.0 * row[3] * root(0, 0), 2.0 * row[4] * root(1, 1), 2.0 * row[5] * root(0, 1));
    });
    const HypothesisFit md = fit_hypothesis(ratio, Hypothesis::kMD).value();
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(ms.constants[i], row[i], 1e-12);
      EXPECT_NEAR(md.constants[i], row[i + 3], 1e-12);
    }
    EXPECT_LT(ms.error, 1e-9);
    EXPECT_LT(md.error, 1e-9);
    // One constant cannot do what three did.
    EXPECT_GT(fit_hypothesis(scaled, Hypothesis::kSS)->error, 0.01);
  }
}

TEST(JointSpace, ReconstructsTheCartesianDampingItWasMadeOf) {
  const auto joints =
      subject([](const Eigen::Matrix2d&, const Eigen::Matrix2d& K) -> Eigen::Matrix2d { return 0.06 * K; });
  const HypothesisFit fit = fit_hypothesis(joints, Hypothesis::kMS).value();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    EXPECT_LT((fit.damping[i] - to_endpoint(joints[i].B, joints[i].jacobian)).norm(), 1e-9);
  }
}

TEST(JointSpace, GivesTheErrorOverTheLargestJointDamping) {
  // Elements B = (1, 3, 0) against K = (1, 1, 0): tau = 2, residuals -1, 1, 0; RMS sqrt(2/3) over 3.
  JointMatrices joint;
  joint.K = Eigen::Matrix2d::Identity();
  joint.B = Eigen::Vector2d(1.0, 3.0).asDiagonal();
  const HypothesisFit fit = fit_hypothesis({&joint, 1}, Hypothesis::kSS).value();
  EXPECT_NEAR(fit.constants[0], 2.0, 1e-14);
  EXPECT_NEAR(fit.error, std::sqrt(2.0 / 3.0) / 3.0, 1e-14);
  EXPECT_NEAR(fit.std[0], std::sqrt(2.0 / 2.0 / 2.0), 1e-14);  // s^2 = 2/(3-1), over sum K^2 = 2.
}

TEST(JointSpace, LeavesOutAndCountsNegativeProducts) {
  auto joints = subject([](const Eigen::Matrix2d& I, const Eigen::Matrix2d& K) -> Eigen::Matrix2d {
    return 0.4 * I.cwiseProduct(K).cwiseSqrt();
  });
  joints[1].K(0, 1) = joints[1].K(1, 0) = -1.0;
  const HypothesisFit sd = fit_hypothesis(joints, Hypothesis::kSD).value();
  EXPECT_EQ(sd.left_out, 1U);
  EXPECT_NEAR(sd.constants[0], 0.2, 1e-12);
  EXPECT_EQ(fit_hypothesis(joints, Hypothesis::kSS)->left_out, 0U);
}

TEST(JointSpace, LetsTheRootFollowTheSignOfTheStiffness) {
  JointMatrices joint;
  joint.I = symmetric(0.3, 0.1, -0.05);
  joint.K = symmetric(30.0, 20.0, -8.0);
  joint.B = 2.0 * 0.25 * symmetric(std::sqrt(9.0), std::sqrt(2.0), -std::sqrt(0.4));
  const HypothesisFit sd = fit_hypothesis({&joint, 1}, Hypothesis::kSD).value();
  EXPECT_EQ(sd.left_out, 0U);
  EXPECT_NEAR(sd.constants[0], 0.25, 1e-12);
}

TEST(JointSpace, RefusesTooLittleToFit) {
  EXPECT_FALSE(fit_hypothesis({}, Hypothesis::kSS));
  const JointMatrices one;
  EXPECT_EQ(fit_hypothesis({&one, 1}, Hypothesis::kMS).error().message,
            "hypothesis MS: 1 elements for constant 1 are not allowed; expected 2 or more");
  const PostureImpedance far{{0.0, 0.9}, {}};
  EXPECT_FALSE(joint_matrices({&far, 1}, typical_arm().links()));
}

}  // namespace
}  // namespace tonus::impedance::test
