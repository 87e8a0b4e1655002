#include "services/contract/rig.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "services/contract/trial.hpp"

namespace tonus::contract {
namespace {

TEST(RigDescription, GeometryComesBackAsItWasPut) {
  RigGeometry rig;
  rig.kind = RigKind::kTwoLink;
  rig.links = {0.31, 0.34};
  rig.encoder_zero = {12.0, -7.0};
  rig.encoder_sign = {1.0, -1.0};
  rig.counts_per_unit = {1000.0, 2000.0};
  rig.force_calibration << 4.0, 0.1, -0.2, 5.0;
  rig.force_offset_V = {0.01, -0.02};
  rig.force_sensor_angle = 0.3;
  rig.handle_mass = 0.05;
  rig.force_saturation_V = 9.5;
  v1::RigDescription wire;
  put_geometry(rig, wire);
  const auto back = geometry_of(wire);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->kind, rig.kind);
  EXPECT_EQ(back->links.l1, rig.links.l1);
  EXPECT_EQ(back->links.l2, rig.links.l2);
  EXPECT_EQ(back->encoder_zero, rig.encoder_zero);
  EXPECT_EQ(back->encoder_sign, rig.encoder_sign);
  EXPECT_EQ(back->counts_per_unit, rig.counts_per_unit);
  EXPECT_EQ(back->force_calibration, rig.force_calibration);
  EXPECT_EQ(back->force_offset_V, rig.force_offset_V);
  EXPECT_EQ(back->force_sensor_angle, rig.force_sensor_angle);
  EXPECT_EQ(back->handle_mass, rig.handle_mass);
  EXPECT_EQ(back->force_saturation_V, rig.force_saturation_V);
}

TEST(RigDescription, AKindOfANewerContractIsRefusedByName) {
  v1::RigDescription wire;
  put_geometry({}, wire);
  wire.name("bench");
  wire.kind(static_cast<v1::RigKind>(3));
  const auto rig = geometry_of(wire);
  ASSERT_FALSE(rig);
  EXPECT_EQ(rig.error().message, "rig bench: kind: 3 is not allowed; expected 0 to 2");
}

TEST(SampleFlags, ComeBackAsTheyWerePutAndAreTheContractsBits) {
  for (unsigned bits = 0; bits < 4; ++bits) {
    v1::RigSample sample;
    put_flags({(bits & 1U) != 0, (bits & 2U) != 0}, sample);
    EXPECT_EQ(sample.flags(), bits);
    EXPECT_EQ(flags_of(sample).is_saturated, (bits & v1::SAMPLE_SATURATED) != 0);
    EXPECT_EQ(flags_of(sample).is_missing, (bits & v1::SAMPLE_MISSING) != 0);
  }
}

/// The pages' unitOf() is held by the same file: tests/unit/services/dashboard/web/matrices.test.ts.
TEST(MatrixUnits, FollowFromTheUnitsOfTheChannels) {
  const auto cases = nlohmann::json::parse(
      std::ifstream(std::string(TONUS_SOURCE_DIR) + "/tests/unit/services/contract/matrix_units.json"));
  ASSERT_FALSE(cases.empty());
  for (const auto& one : cases) {
    SCOPED_TRACE(one.dump());
    const MatrixUnits units = matrix_units({one.at("displacement"), one.at("force")});
    EXPECT_EQ(units.mass, one.at("mass"));
    EXPECT_EQ(units.damping, one.at("damping"));
    EXPECT_EQ(units.stiffness, one.at("stiffness"));
  }
}

TEST(TrialProgram, ShoulderComesBackAsItWasPut) {
  v1::TrialProgram program;
  put_shoulder({{0.1, -0.2}, 0.3}, program);
  const ShoulderPose shoulder = shoulder_of(program);
  EXPECT_EQ(shoulder.origin, Eigen::Vector2d(0.1, -0.2));
  EXPECT_EQ(shoulder.angle, 0.3);
}

TEST(TrialProgram, BeginsInTheFirstSetAndReplaysNoRecording) {
  const auto program = new_program(v1::TRIAL_RECORDING, {"distal", 2, {0.1, 0.5}});
  EXPECT_EQ(program.kind(), v1::TRIAL_RECORDING);
  EXPECT_EQ(program.posture(), "distal");
  EXPECT_EQ(program.posture_index(), 2U);
  EXPECT_EQ(program.posture_m(), (std::array<double, 2>{0.1, 0.5}));
  EXPECT_EQ(program.set_number(), 1);
  EXPECT_LT(program.recording_index(), 0);
  EXPECT_LT(program.recording_event(), 0);
}

}  // namespace
}  // namespace tonus::contract
