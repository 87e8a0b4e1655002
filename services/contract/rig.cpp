#include "services/contract/rig.hpp"

#include <spdlog/fmt/fmt.h>

namespace tonus::contract {

std::optional<RigKind> kind_of(v1::RigKind wire) {
  switch (wire) {
    case v1::RIG_TWO_LINK:
      return RigKind::kTwoLink;
    case v1::RIG_CARTESIAN:
      return RigKind::kCartesian;
    case v1::RIG_ONE_AXIS:
      return RigKind::kOneAxis;
  }
  return std::nullopt;
}

v1::RigKind to_wire(RigKind kind) {
  switch (kind) {
    case RigKind::kTwoLink:
      return v1::RIG_TWO_LINK;
    case RigKind::kCartesian:
      return v1::RIG_CARTESIAN;
    case RigKind::kOneAxis:
      return v1::RIG_ONE_AXIS;
  }
  return v1::RIG_TWO_LINK;
}

Result<RigGeometry> geometry_of(const v1::RigDescription& description) {
  const auto kind = kind_of(description.kind());
  if (!kind) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("rig {}: kind: {} is not allowed; expected 0 to 2", description.name(),
                            static_cast<std::uint32_t>(description.kind())));
  }
  RigGeometry rig;
  rig.kind = *kind;
  rig.links = {description.link_lengths_m()[0], description.link_lengths_m()[1]};
  rig.encoder_zero = description.encoder_zero_count();
  rig.encoder_sign = description.encoder_sign();
  rig.counts_per_unit = description.encoder_counts_per_unit();
  const auto& c = description.force_calibration_N_per_V();
  rig.force_calibration << c[0], c[1], c[2], c[3];
  rig.force_offset_V = {description.force_offset_V()[0], description.force_offset_V()[1]};
  rig.force_sensor_angle = description.force_sensor_angle_rad();
  rig.handle_mass = description.handle_mass_kg();
  rig.force_saturation_V = description.force_saturation_V();
  TONUS_TRY(validate(rig));
  return rig;
}

Result<std::vector<AuxiliaryChannel>> auxiliary_channels_of(const v1::RigDescription& description) {
  std::vector<AuxiliaryChannel> channels;
  for (const v1::AuxiliaryChannel& wire : description.auxiliary_channels()) {
    channels.push_back({wire.name(), wire.type(), wire.unit(), wire.unit_per_value(),
                        wire.values_per_sample() * description.sample_rate_Hz()});
  }
  TONUS_TRY(validate(channels, description.sample_rate_Hz()));
  return channels;
}

void put_auxiliary_channels(std::span<const AuxiliaryChannel> channels, v1::RigDescription& description) {
  description.auxiliary_channels().clear();
  for (const AuxiliaryChannel& channel : channels) {
    v1::AuxiliaryChannel wire;
    wire.name(channel.name);
    wire.type(channel.type);
    wire.unit(channel.unit);
    wire.unit_per_value(channel.unit_per_value);
    wire.values_per_sample(values_per_sample(channel, description.sample_rate_Hz()));
    description.auxiliary_channels().push_back(wire);
  }
}

void put_geometry(const RigGeometry& geometry, v1::RigDescription& description) {
  description.kind(to_wire(geometry.kind));
  description.link_lengths_m({geometry.links.l1, geometry.links.l2});
  description.encoder_counts_per_unit(geometry.counts_per_unit);
  description.encoder_zero_count(geometry.encoder_zero);
  description.encoder_sign(geometry.encoder_sign);
  const auto& c = geometry.force_calibration;
  description.force_calibration_N_per_V({c(0, 0), c(0, 1), c(1, 0), c(1, 1)});
  description.force_offset_V({geometry.force_offset_V[0], geometry.force_offset_V[1]});
  description.force_sensor_angle_rad(geometry.force_sensor_angle);
  description.force_saturation_V(geometry.force_saturation_V);
  description.handle_mass_kg(geometry.handle_mass);
}

ShoulderPose shoulder_of(const v1::TrialProgram& program) {
  return {{program.shoulder_origin_m()[0], program.shoulder_origin_m()[1]}, program.shoulder_angle_rad()};
}

void put_shoulder(const ShoulderPose& shoulder, v1::TrialProgram& program) {
  program.shoulder_origin_m({shoulder.origin[0], shoulder.origin[1]});
  program.shoulder_angle_rad(shoulder.angle);
}

SampleFlags flags_of(const v1::RigSample& sample) {
  return {(sample.flags() & v1::SAMPLE_SATURATED) != 0, (sample.flags() & v1::SAMPLE_MISSING) != 0};
}

void put_flags(const SampleFlags& flags, v1::RigSample& sample) {
  unsigned bits = 0;
  if (flags.is_saturated) bits |= v1::SAMPLE_SATURATED;
  if (flags.is_missing) bits |= v1::SAMPLE_MISSING;
  sample.flags(static_cast<std::uint8_t>(bits));
}

MatrixUnits matrix_units(const RigUnits& units) {
  const std::string displacement = units.displacement.empty() ? "m" : units.displacement;
  const std::string force = units.force.empty() ? "N" : units.force;
  if (displacement == "m" && force == "N") return {};
  if (displacement == "rad" && force == "N m") return {"kg m2", "N m s/rad", "N m/rad"};
  return {force + " s2/" + displacement, force + " s/" + displacement, force + "/" + displacement};
}

}  // namespace tonus::contract
