// Raw counts and volts to SI against conversion_cases.json, whose expected values come from a Python program
// in complex arithmetic. The pages' conversion is held by the same file:
// tests/unit/services/dashboard/web/geometry.test.ts.

#include <fstream>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "services/mechanics/rig_geometry.hpp"

namespace tonus {
namespace {

using Pair = std::array<double, 2>;

RigKind kind_of(const std::string& name) {
  if (name == "two_link") return RigKind::kTwoLink;
  if (name == "cartesian") return RigKind::kCartesian;
  EXPECT_EQ(name, "one_axis");
  return RigKind::kOneAxis;
}

RigGeometry rig_of(const nlohmann::json& one) {
  RigGeometry rig;
  rig.kind = kind_of(one.at("kind"));
  const auto lengths = one.at("link_lengths_m").get<Pair>();
  rig.links = TwoLink{lengths[0], lengths[1]};
  rig.encoder_zero = one.at("encoder_zero_count").get<Pair>();
  rig.encoder_sign = one.at("encoder_sign").get<Pair>();
  rig.counts_per_unit = one.at("encoder_counts_per_unit").get<Pair>();
  const auto calibration = one.at("force_calibration_N_per_V").get<std::array<double, 4>>();
  rig.force_calibration << calibration[0], calibration[1], calibration[2], calibration[3];
  const auto offset = one.at("force_offset_V").get<Pair>();
  rig.force_offset_V = {offset[0], offset[1]};
  rig.force_sensor_angle = one.at("force_sensor_angle_rad");
  return rig;
}

TEST(ConversionCases, GiveTheExpectedPositionAndForce) {
  const auto cases = nlohmann::json::parse(std::ifstream(TONUS_CONVERSION_CASES));
  ASSERT_FALSE(cases.empty());
  for (const auto& one : cases) {
    SCOPED_TRACE(one.at("name").get<std::string>());
    const auto origin = one.at("shoulder_origin_m").get<Pair>();
    const ShoulderPose shoulder{{origin[0], origin[1]}, one.at("shoulder_angle_rad")};
    const RawSample raw{0, one.at("encoder_count").get<Pair>(), one.at("force_V").get<Pair>()};
    const EndpointSample found = convert(rig_of(one), shoulder, raw);
    const auto position = one.at("expected_position").get<Pair>();
    const auto force = one.at("expected_force").get<Pair>();
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_NEAR(found.p_SE[static_cast<Eigen::Index>(i)], position[i], 1e-12);
      EXPECT_NEAR(found.f_S[static_cast<Eigen::Index>(i)], force[i], 1e-12);
    }
  }
}

}  // namespace
}  // namespace tonus
