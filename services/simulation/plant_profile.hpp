#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "services/mechanics/auxiliary_channel.hpp"
#include "services/mechanics/rig_geometry.hpp"
#include "services/mechanics/two_link.hpp"
#include "services/mechanics/two_link_dynamics.hpp"
#include "services/simulation/subject_profile.hpp"

namespace tonus::simulation {

/// The simulated manipulandum. Links are thin uniform rods; each motor's rotor turns with its link, and the
/// elbow's motor sits with its whole mass on the elbow.
struct ManipulandumProfile {
  TwoLink links{0.30, 0.35};
  Eigen::Vector2d link_masses{1.0, 0.8};       ///< kg.
  Eigen::Vector2d rotor_inertias{0.50, 0.85};  ///< kg m2.
  double elbow_motor_mass = 2.0;               ///< kg.
  double tip_mass = 0.30;  ///< kg, sensor and handle, without the part beyond the flexure.
  control::JointFriction friction{{0.05, 0.05}, {0.03, 0.03}, 0.02};
  Eigen::Vector2d torque_limits{25.0, 25.0};  ///< N m.
  Eigen::Vector2d motor_gains{1.0, 1.0};      ///< Torque given over torque commanded; less: weak motors.
  double motor_time_constant = 0.001;         ///< s, first-order lag from command to torque; 0 = none.
  Eigen::Vector2d home{0.30, 0.35};           ///< m in R, where the handle is at the start.
};

/// How the true sensors differ from what the driver's geometry says of them: what a calibration has to find.
struct SensorErrors {
  Eigen::Vector2d zero_count = Eigen::Vector2d::Zero();  ///< Added to the encoders' counts.
  Eigen::Vector2d offset_V = Eigen::Vector2d::Zero();    ///< Added to the sensor's volts.
  /// Rows of the matrix that the true force is multiplied by before it is measured: gain and crosstalk.
  Eigen::Vector2d force_row_x{1.0, 0.0};
  Eigen::Vector2d force_row_y{0.0, 1.0};
};

/// Encoders and force sensor.
struct SensorProfile {
  double encoder_counts_per_rev = 8000.0;
  Eigen::Vector2d encoder_zero = Eigen::Vector2d::Zero();  ///< Count at angle 0.
  double force_full_scale = 44.5;                          ///< N at full scale.
  double voltage_full_scale = 10.0;  ///< V at full scale; beyond it the sensor is clipped.
  double force_resolution = 0.011;   ///< N, step of the converter.
  double force_noise = 0.05;         ///< N, standard deviation, white, each axis.
  Eigen::Vector2d force_offset_V = Eigen::Vector2d::Zero();  ///< V at no force, known to the description.
  double force_sensor_angle = 0.0;                           ///< rad from the outer link.
  double handle_mass = 0.05;                                 ///< kg beyond the flexure.
  SensorErrors errors;
};

/// The hand's hold on the handle: a spring and damper in both directions of the plane.
struct GripProfile {
  double stiffness = 5.0e5;  ///< N/m.
  double damping = 500.0;    ///< N s/m.
};

/// The rig on the bench, without a subject: weights that pull the handle over pulleys, and springs that hold
/// it. Pull of the two on the handle: load - spring (x - home) - damping x', in R.
struct BenchProfile {
  bool is_on = false;
  bool is_clamped = false;                           ///< The links cannot move.
  Eigen::Vector2d load = Eigen::Vector2d::Zero();    ///< N.
  Eigen::Vector2d spring = Eigen::Vector2d::Zero();  ///< N/m, along x and y.
  double damping = 0.0;                              ///< N s/m.
};

/// A simulated rig with its subject: what the plant is made of.
struct PlantProfile {
  ManipulandumProfile manipulandum;
  SensorProfile sensors;
  GripProfile grip;
  SubjectProfile subject;
  BenchProfile bench;
  std::uint64_t seed = 1;
  std::vector<AuxiliaryChannel> auxiliary;  ///< What is recorded beside force and motion.
  unsigned sub_steps = 3;                   ///< Integration steps in one period of the loop.
};

/// The description that this rig would publish: what converts its counts and volts.
[[nodiscard]] RigGeometry rig_geometry(const PlantProfile& profile);
/// The inertia and friction of the simulated manipulandum (tip and handle included).
[[nodiscard]] control::ManipulandumModel manipulandum_model(const ManipulandumProfile& profile,
                                                            double handle_mass);

}  // namespace tonus::simulation
