#include "services/simulation/plant_profile.hpp"

#include <numbers>

namespace tonus::simulation {

RigGeometry rig_geometry(const PlantProfile& profile) {
  const SensorProfile& sensors = profile.sensors;
  RigGeometry rig;
  rig.kind = RigKind::kTwoLink;
  rig.links = profile.manipulandum.links;
  rig.encoder_zero = {sensors.encoder_zero[0], sensors.encoder_zero[1]};
  rig.counts_per_unit.fill(sensors.encoder_counts_per_rev / (2.0 * std::numbers::pi));
  rig.force_calibration =
      (sensors.force_full_scale / sensors.voltage_full_scale) * Eigen::Matrix2d::Identity();
  rig.force_offset_V = sensors.force_offset_V;
  rig.force_sensor_angle = sensors.force_sensor_angle;
  rig.handle_mass = sensors.handle_mass;
  rig.force_saturation_V = sensors.voltage_full_scale;
  return rig;
}

control::ManipulandumModel manipulandum_model(const ManipulandumProfile& rig, double handle_mass) {
  const double l1 = rig.links.l1;
  const double l2 = rig.links.l2;
  const double tip = rig.tip_mass + handle_mass;
  const double at_elbow = rig.elbow_motor_mass + rig.link_masses[1] + tip;
  control::ManipulandumModel model;
  model.inertia.inner = rig.rotor_inertias[0] + rig.link_masses[0] * l1 * l1 / 3.0 + at_elbow * l1 * l1;
  model.inertia.outer = rig.rotor_inertias[1] + rig.link_masses[1] * l2 * l2 / 3.0 + tip * l2 * l2;
  model.inertia.coupling = l1 * (0.5 * rig.link_masses[1] + tip) * l2;
  model.friction = rig.friction;
  return model;
}

}  // namespace tonus::simulation
