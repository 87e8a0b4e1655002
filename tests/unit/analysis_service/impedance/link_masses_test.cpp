#include "analysis_service/impedance/link_masses.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "tests/support/impedance/linear_rig.hpp"

namespace tonus::impedance::test {
namespace {

std::vector<PostureMass> matrices_of(const ArmModel& arm) {
  std::vector<PostureMass> postures;
  for (const auto& position : published_positions()) {
    postures.push_back({position, forward_model(arm, {}, {}, position)->M, true});
  }
  return postures;
}

LimbSize size_of(const ArmModel& arm) {
  return {arm.upper_arm.length, arm.forearm.length, arm.upper_arm.radius, arm.forearm.radius};
}

TEST(LinkMasses, AreRecoveredFromExactMatrices) {
  const ArmModel arm = typical_arm();
  const LinkMasses found = fit_link_masses(matrices_of(arm), size_of(arm)).value();
  EXPECT_NEAR(found.mass[0], 1.8, 1e-10);
  EXPECT_NEAR(found.mass[1], 1.5, 1e-10);
  EXPECT_LT(found.std.maxCoeff(), 1e-10);
  EXPECT_LT(found.sigma, 1e-10);
}

TEST(LinkMasses, AreRecoveredWithRadiiThatFollowFromTheMasses) {
  ArmModel arm = typical_arm();
  arm.upper_arm.radius = radius_from_mass(arm.upper_arm.mass, arm.upper_arm.length);
  arm.forearm.radius = radius_from_mass(arm.forearm.mass, arm.forearm.length);
  const LinkMasses found =
      fit_link_masses(matrices_of(arm), {0.30, 0.35, std::nullopt, std::nullopt}).value();
  EXPECT_NEAR(found.mass[0], 1.8, 1e-9);
  EXPECT_NEAR(found.mass[1], 1.5, 1e-9);
  EXPECT_NEAR(found.arm.upper_arm.radius, arm.upper_arm.radius, 1e-10);
}

TEST(LinkMasses, LeaveOutThePostureThatIsNotUsedAndModelItAllTheSame) {
  const ArmModel arm = typical_arm();
  auto postures = matrices_of(arm);
  const Eigen::Matrix2d proximal = postures[2].M;
  postures[2].M *= 3.0;
  postures[2].is_used = false;
  const LinkMasses found = fit_link_masses(postures, size_of(arm)).value();
  EXPECT_NEAR(found.mass[0], 1.8, 1e-10);
  ASSERT_EQ(found.modelled.size(), 5U);
  EXPECT_LT((found.modelled[2] - proximal).norm(), 1e-10);
}

TEST(LinkMasses, StateTheStandardDeviationTheyHave) {
  const ArmModel arm = typical_arm();
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, 0.1);
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  Eigen::Vector2d stated = Eigen::Vector2d::Zero();
  const int repeats = 400;
  for (int i = 0; i < repeats; ++i) {
    auto postures = matrices_of(arm);
    for (auto& posture : postures) {
      for (double& element : posture.M.reshaped()) element += noise(random);
    }
    const LinkMasses found = fit_link_masses(postures, size_of(arm)).value();
    squares += (found.mass - Eigen::Vector2d(1.8, 1.5)).cwiseAbs2();
    stated += found.std.cwiseAbs2();
  }
  EXPECT_NEAR(std::sqrt(stated[0] / squares[0]), 1.0, 0.1);
  EXPECT_NEAR(std::sqrt(stated[1] / squares[1]), 1.0, 0.1);
}

TEST(LinkMasses, RefuseWhatTheyCannotBeFittedTo) {
  EXPECT_EQ(fit_link_masses({}, size_of(typical_arm())).error().message,
            "link masses: 0 postures to fit are not allowed; expected 1 or more");
  auto postures = matrices_of(typical_arm());
  postures[0].position = {0.0, 0.8};
  EXPECT_EQ(fit_link_masses(postures, size_of(typical_arm())).error().message,
            "link masses: posture at 0.8 m from the shoulder is not allowed; expected 0.05 to 0.65 m");
  EXPECT_FALSE(fit_link_masses(matrices_of(typical_arm()), {0.0, 0.35, {}, {}}));
}

}  // namespace
}  // namespace tonus::impedance::test
