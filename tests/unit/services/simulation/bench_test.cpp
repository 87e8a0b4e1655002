// The bench mode of the plant: weights and springs in place of a subject.
#include <gtest/gtest.h>

#include "services/simulation/plant.hpp"

namespace tonus::simulation {
namespace {

constexpr double kPeriod = 0.001;

TEST(Bench, HoldsAWeightAgainstTheClampWithTheOppositeForce) {
  PlantProfile profile;
  profile.bench.is_on = true;
  profile.bench.is_clamped = true;
  profile.bench.load = {4.0, -3.0};
  Plant plant(profile, kPeriod);
  const Eigen::Vector2d start = plant.handle();
  for (int i = 0; i < 500; ++i) plant.step({1.0, 1.0});
  EXPECT_EQ(plant.handle(), start);
  EXPECT_TRUE(plant.flexure_force().isApprox(Eigen::Vector2d(-4.0, 3.0), 1e-12));
}

TEST(Bench, SettlesWhereWeightAndSpringBalance) {
  PlantProfile profile;
  profile.bench.is_on = true;
  profile.bench.load = {2.0, -1.0};
  profile.bench.spring = {400.0, 200.0};
  profile.bench.damping = 60.0;
  profile.manipulandum.friction.coulomb = {0.0, 0.0};
  Plant plant(profile, kPeriod);
  for (int i = 0; i < 20'000; ++i) plant.step(Eigen::Vector2d::Zero());
  const Eigen::Vector2d moved = plant.handle() - profile.manipulandum.home;
  EXPECT_NEAR(moved.x(), 2.0 / 400.0, 1e-6);
  EXPECT_NEAR(moved.y(), -1.0 / 200.0, 1e-6);
  EXPECT_LT(plant.flexure_force().norm(), 1e-3);
}

TEST(Bench, LeavesTheSubjectAloneAlsoWhenATrialSeatsHim) {
  PlantProfile profile;
  profile.bench.is_on = true;
  Plant plant(profile, kPeriod);
  plant.seat({{0.3, 0.35}, 0.0}, {0.0, 0.0});  // A place that no arm reaches.
  for (int i = 0; i < 100; ++i) plant.step(Eigen::Vector2d::Zero());
  EXPECT_TRUE(plant.state().t.allFinite());
  EXPECT_EQ(plant.handle(), profile.manipulandum.links.endpoint(
                                profile.manipulandum.links.angles_at(profile.manipulandum.home)));
}

TEST(SensorErrors, AreInTheMeasurementAndNotInTheDescription) {
  PlantProfile profile;
  profile.sensors.force_noise = 0.0;
  profile.sensors.force_resolution = 0.0;
  profile.bench.is_on = true;
  profile.bench.is_clamped = true;
  profile.bench.load = {-10.0, 0.0};
  PlantProfile wrong = profile;
  wrong.sensors.errors.zero_count = {100.0, -50.0};
  wrong.sensors.errors.offset_V = {0.5, 0.25};
  wrong.sensors.errors.force_row_x = {0.0, 2.0};
  wrong.sensors.errors.force_row_y = {1.0, 0.0};
  EXPECT_EQ(rig_geometry(wrong).force_offset_V, rig_geometry(profile).force_offset_V);
  EXPECT_EQ(rig_geometry(wrong).encoder_zero, rig_geometry(profile).encoder_zero);
  const RawSample good = Plant(profile, kPeriod).measure();
  const RawSample bad = Plant(wrong, kPeriod).measure();
  EXPECT_NEAR(bad.encoder_count[0], good.encoder_count[0] + 100.0, 1.0);
  EXPECT_NEAR(bad.encoder_count[1], good.encoder_count[1] - 50.0, 1.0);
  EXPECT_NEAR(bad.force_V[0], 2.0 * good.force_V[1] + 0.5, 1e-12);
  EXPECT_NEAR(bad.force_V[1], good.force_V[0] + 0.25, 1e-12);
}

}  // namespace
}  // namespace tonus::simulation
