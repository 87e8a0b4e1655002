#include <gtest/gtest.h>

#include "analysis_service/impedance/identification.hpp"
#include "tests/support/impedance/linear_rig.hpp"

namespace tonus::impedance::test {
namespace {

/// sigma (16) of each model, in the order of kModels, for the same trials.
std::vector<AxisVector> sigmas(const std::vector<Trial>& trials, Method method = Method::kStateVariable) {
  std::vector<AxisVector> found;
  for (const Model model : kModels) {
    Options options;
    options.method = method;
    options.model = model;
    found.push_back(identify(trials, options)->sigma);
  }
  return found;
}

constexpr std::size_t kLinear = 0;
constexpr std::size_t kNoDamping = 1;
constexpr std::size_t kCoriolis = 2;
constexpr std::size_t kSquared = 3;

TEST(ModelComparison, OrdersTheModelsAsTableTwoDoes) {
  for (const Method method : {Method::kLowpass, Method::kStateVariable}) {
    for (const auto& position : published_positions()) {
      SimulatedArm arm = typical_subject(position);
      arm.velocity_products = typical_arm().coriolis_matrix(typical_arm().links().angles_at(position), true);
      arm.drift_rms = 0.15;
      arm.tremor_rms = 0.05;
      const auto sigma = sigmas(simulate(arm, SimulatedRig{}, directions(), 4), method);
      for (int axis = 0; axis < 2; ++axis) {
        EXPECT_GT(sigma[kNoDamping][axis], sigma[kLinear][axis]);
        EXPECT_LT(sigma[kNoDamping][axis] - sigma[kCoriolis][axis], 0.005);  // N
        EXPECT_LT(sigma[kLinear][axis] - sigma[kSquared][axis], 0.05);       // N, the sensor's noise.
      }
    }
  }
}

TEST(ModelComparison, SeesCoriolisForcesWhereTheyAreAllThereIs) {
  // No joint damping, ten times the amplitude and so ten times the speed.
  SimulatedArm arm = typical_subject();
  arm.impedance.B.setZero();
  arm.velocity_products = typical_arm().coriolis_matrix(typical_arm().links().angles_at({0.0, 0.38}), true);
  SimulatedRig rig;
  rig.amplitude = 0.05;
  const auto sigma = sigmas(simulate(arm, rig, directions(), 4));
  EXPECT_LT(sigma[kCoriolis].maxCoeff(), 0.8 * sigma[kNoDamping].maxCoeff());
}

TEST(ModelComparison, RecoversTheVelocityProductsItWasGiven) {
  SimulatedArm arm = typical_subject();
  arm.impedance.B.setZero();
  arm.velocity_products << 4.0, -3.0, 1.0, 2.0, 5.0, -6.0;
  SimulatedRig rig = ideal_rig();
  rig.amplitude = 0.05;
  rig.encoder_counts = 0.0;
  Options options;
  options.model = Model::kCoriolis;
  const Estimate estimate = identify(simulate(arm, rig, directions(), 1), options).value();
  ASSERT_EQ(estimate.value.B.cols(), 3);
  EXPECT_LT(relative_error(estimate.value.B, arm.velocity_products), 0.05);
  EXPECT_LT(relative_error(estimate.value.M, arm.impedance.M), 0.02);
}

TEST(ModelComparison, HasNoVelocityTermWithoutDamping) {
  Options options;
  options.model = Model::kNoDamping;
  const Estimate e = identify(simulate(typical_subject(), SimulatedRig{}, directions(), 1), options).value();
  EXPECT_EQ(e.value.B.size(), 0);
  EXPECT_EQ(e.value.K.rows(), 2);
}

}  // namespace
}  // namespace tonus::impedance::test
