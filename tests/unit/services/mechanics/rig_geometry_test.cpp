#include "services/mechanics/rig_geometry.hpp"

#include <gtest/gtest.h>
#include <numbers>

namespace tonus {
namespace {

constexpr double kCountsPerTurn = 8000.0;

RigGeometry rig() {
  RigGeometry r;
  r.counts_per_unit = {kCountsPerTurn / (2 * std::numbers::pi), kCountsPerTurn / (2 * std::numbers::pi)};
  return r;
}

TEST(Conversion, TurnsCountsIntoJointAnglesWithZeroAndSign) {
  RigGeometry r = rig();
  r.encoder_zero = {100.0, -50.0};
  r.encoder_sign = {1.0, -1.0};
  const Eigen::Vector2d q = joint_coordinates(r, {0, {2100.0, -2050.0}, {}});
  EXPECT_NEAR(q[0], std::numbers::pi / 2, 1e-12);  // a quarter of a turn
  EXPECT_NEAR(q[1], std::numbers::pi / 2, 1e-12);
}

TEST(Conversion, TurnsTheForceWithTheOuterLinkIntoTheShoulderFrame) {
  // Inner link along x, outer link along y: the sensor's x axis stands along the robot's y. The shoulder
  // frame is turned by a quarter too, so that the robot's y is the shoulder's x. 1 V is 4.45 N.
  const ShoulderPose shoulder{{0.0, 0.0}, std::numbers::pi / 2};
  const EndpointSample s = convert(rig(), shoulder, {7, {0.0, 2000.0}, {1.0, 0.0}});
  EXPECT_TRUE(s.f_S.isApprox(Eigen::Vector2d(4.45, 0.0), 1e-12));
  EXPECT_EQ(s.acquisition_ns, 7);
}

TEST(Conversion, PlacesTheEndpointRelativeToTheShoulder) {
  const ShoulderPose shoulder{{0.10, 0.05}, 0.0};
  const EndpointSample s = convert(rig(), shoulder, {0, {0.0, 2000.0}, {}});
  EXPECT_TRUE(s.p_SE.isApprox(Eigen::Vector2d(0.20, 0.30), 1e-12));  // (0.30, 0.35) less the shoulder
}

TEST(Conversion, SubtractsTheSensorsOffsetBeforeTheCalibration) {
  RigGeometry r = rig();
  r.force_offset_V = {0.5, -0.25};
  const EndpointSample s = convert(r, {}, {0, {0.0, 0.0}, {0.5, -0.25}});
  EXPECT_EQ(s.f_S, Eigen::Vector2d::Zero());
}

TEST(Conversion, PassesConvertedRecordingsThroughUnchanged) {
  RigGeometry r;
  r.kind = RigKind::kOneAxis;
  r.counts_per_unit = {1.0, 1.0};
  r.force_calibration.setIdentity();
  const EndpointSample s = convert(r, {}, {0, {0.13220996, 0.0}, {-1.9743403, 0.0}});
  EXPECT_EQ(s.p_SE[0], 0.13220996);
  EXPECT_EQ(s.f_S[0], -1.9743403);
}

TEST(RigGeometryCheck, NamesTheValueThatIsRefused) {
  RigGeometry r;
  r.links.l2 = -0.1;
  EXPECT_EQ(validate(r).error().message,
            "rig: LinkLengths_m[1]: -0.1 is not allowed; expected more than 0 m");
  r = {};
  r.force_calibration << 1.0, 2.0, 2.0, 4.0;
  EXPECT_FALSE(validate(r));
  r = {};
  r.encoder_sign[0] = 0.5;
  EXPECT_FALSE(validate(r));
  EXPECT_TRUE(validate(RigGeometry{}));
}

}  // namespace
}  // namespace tonus
