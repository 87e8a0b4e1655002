#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <set>

#include "rig_agent/control/validation.hpp"
#include "services/simulation/plant.hpp"

namespace tonus::simulation {
namespace {

constexpr double kPeriod = 0.001;

TEST(PlantSensors, CountEncoderStepsDownwards) {
  PlantProfile profile;
  profile.sensors.encoder_zero = {100.0, -50.0};
  Plant plant(profile, kPeriod);
  for (int i = 0; i < 300; ++i) {
    plant.step({0.5, -0.4});
    const RawSample raw = plant.measure();
    for (int joint = 0; joint < 2; ++joint) {
      const double exact =
          profile.sensors.encoder_zero[joint] + plant.state().q[joint] * 8000.0 / (2.0 * std::numbers::pi);
      ASSERT_EQ(raw.encoder_count[static_cast<std::size_t>(joint)], std::floor(exact));
    }
  }
}

TEST(PlantSensors, RoundVoltsToTheConvertersStepWithThePublishedNoise) {
  const PlantProfile profile;
  Plant plant(profile, kPeriod);
  const double step_V = 0.011 / 4.45;
  constexpr int kCount = 20'000;
  double sum = 0.0;
  double squares = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const RawSample raw = plant.measure();  // At rest at the spring centre: no force but noise.
    ASSERT_NEAR(raw.force_V[0] / step_V, std::round(raw.force_V[0] / step_V), 1e-6);
    sum += 4.45 * raw.force_V[0];
    squares += std::pow(4.45 * raw.force_V[0], 2);
  }
  // Noise of 0.05 N and a rounding of 0.011 N / sqrt(12); five standard errors.
  const double expected = 0.05 * 0.05 + 0.011 * 0.011 / 12.0;
  EXPECT_NEAR(sum / kCount, 0.0, 5.0 * 0.05 / std::sqrt(kCount));
  EXPECT_NEAR(squares / kCount, expected, 5.0 * expected * std::sqrt(2.0 / kCount));
}

TEST(PlantSensors, ClipAtFullScale) {
  PlantProfile profile;
  profile.sensors.force_full_scale = 0.01;
  Plant plant(profile, kPeriod);
  std::set<double> volts;
  for (int i = 0; i < 200; ++i) volts.insert(plant.measure().force_V[0]);
  EXPECT_EQ(*volts.begin(), -10.0);
  EXPECT_EQ(*volts.rbegin(), 10.0);
}

TEST(PlantSensors, AreConvertedBackToTheTrueForceAndPlaceByTheDescription) {
  PlantProfile profile;
  profile.sensors.force_noise = 0.0;
  profile.sensors.force_sensor_angle = 0.6;
  profile.sensors.force_offset_V = {0.3, -0.2};
  profile.sensors.handle_mass = 0.0;
  Plant plant(profile, kPeriod);
  const Eigen::Vector2d posture(-0.295, 0.38);
  const ShoulderPose shoulder =
      control::shoulder_for(profile.manipulandum.home + Eigen::Vector2d(0.01, 0.005), posture, 0.8);
  plant.seat(shoulder, posture);
  for (int i = 0; i < 57; ++i) plant.step({0.3, 0.1});
  const EndpointSample sample = convert(rig_geometry(profile), shoulder, plant.measure());
  const Eigen::Vector2d f_R(std::cos(0.8) * sample.f_S.x() - std::sin(0.8) * sample.f_S.y(),
                            std::sin(0.8) * sample.f_S.x() + std::cos(0.8) * sample.f_S.y());
  ASSERT_GT(plant.flexure_force().norm(), 0.5);
  EXPECT_LT((f_R - plant.flexure_force()).norm(), 0.02);
  const Eigen::Vector2d p_R =
      shoulder.origin + Eigen::Vector2d(std::cos(0.8) * sample.p_SE.x() - std::sin(0.8) * sample.p_SE.y(),
                                        std::sin(0.8) * sample.p_SE.x() + std::cos(0.8) * sample.p_SE.y());
  EXPECT_LT((p_R - plant.handle()).norm(), 0.0006);
}

TEST(PlantSensors, FeelTheInertiaOfTheHandleBeyondTheFlexure) {
  // The hand is open: what the flexure bears is m_h a alone.
  PlantProfile profile;
  profile.sensors.handle_mass = 0.5;
  profile.subject.letting_go = {true, 0.0, 1e6};
  Plant plant(profile, kPeriod);
  Eigen::Vector2d before = plant.handle();
  Eigen::Vector2d here = before;
  Eigen::Vector2d force = Eigen::Vector2d::Zero();
  for (int i = 0; i < 100; ++i) {
    before = here;
    here = plant.handle();
    force = plant.flexure_force();
    plant.step({2.0, -1.0});
  }
  const Eigen::Vector2d acceleration = (plant.handle() - 2.0 * here + before) / (kPeriod * kPeriod);
  ASSERT_GT(acceleration.norm(), 0.5);
  EXPECT_LT((force - 0.5 * acceleration).norm(), 0.002 * force.norm());
}

TEST(PlantSensors, StampTheirOwnClock) {
  Plant plant(PlantProfile{}, 0.00025);
  EXPECT_EQ(plant.measure().acquisition_ns, 0);
  for (int i = 0; i < 8; ++i) plant.step({0.0, 0.0});
  EXPECT_EQ(plant.measure().acquisition_ns, 2'000'000);
}

}  // namespace
}  // namespace tonus::simulation
