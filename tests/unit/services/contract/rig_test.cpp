#include "services/contract/rig.hpp"

#include <gtest/gtest.h>

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

TEST(MatrixUnits, FollowFromTheUnitsOfTheChannels) {
  EXPECT_EQ(matrix_units({"m", "N"}).stiffness, "N/m");
  EXPECT_EQ(matrix_units({"rad", "N m"}).mass, "kg m2");
  EXPECT_EQ(matrix_units({"rad", "N m"}).damping, "N m s/rad");
  EXPECT_EQ(matrix_units({"m", "V"}).mass, "V s2/m");
  EXPECT_EQ(matrix_units({"m", "V"}).damping, "V s/m");
  EXPECT_EQ(matrix_units({"rad", "V"}).stiffness, "V/rad");
  EXPECT_EQ(matrix_units({"", ""}).mass, "kg");
  EXPECT_EQ(matrix_units({"", "V"}).damping, "V s/m");
}

}  // namespace
}  // namespace tonus::contract
