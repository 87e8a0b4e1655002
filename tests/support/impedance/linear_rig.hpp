#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "analysis_service/impedance/arm_model.hpp"
#include "analysis_service/impedance/trial.hpp"
#include "services/mechanics/rig_geometry.hpp"

namespace tonus::impedance::test {

/// A subject of known impedance at one posture: F = M X" + B X' + K (X - X0) + B_C [x1'^2, x1' x2', x2'^2]' +
/// d, d being the force of slow drift and tremor. The truth that tests compare with.
struct SimulatedArm {
  CartesianImpedance impedance;
  Eigen::Matrix<double, 2, 3> velocity_products = Eigen::Matrix<double, 2, 3>::Zero();  ///< B_C, N s2/m2.
  Eigen::Vector2d X0 = Eigen::Vector2d::Zero();  ///< m, spring centre from the rest position.
  double drift_rms = 0.0;                        ///< N per axis, 0.1 to 1 Hz.
  double tremor_rms = 0.0;                       ///< N per axis, 8 to 12 Hz.
};

/// A compliant manipulandum at one place, and its sensors: handle of mass m on a spring and a damper to the
/// commanded position, which steps by `amplitude` over `rise`. The defaults make an underdamped step of 2.5
/// Hz that stays within 10 mm, and are the paper's sensors.
struct SimulatedRig {
  double mass = 8.0;                 ///< kg, apparent.
  double damping = 20.0;             ///< N s/m.
  double stiffness = 2200.0;         ///< N/m.
  double amplitude = 0.005;          ///< m.
  double rise = 0.02;                ///< s of a straight ramp of the command.
  bool is_command_recorded = false;  ///< Prepared trials hold the command.
  bool is_minimum_jerk = false;      ///< The command rises as a fifth-order polynomial, not straight.
  double rate_share = 0.0;  ///< Of the command's rate, that the damper acts from: 1 follows it, 0 resists it.
  double sample_period = 0.005;
  double rest = 0.5;                          ///< s before the onset.
  double duration = 1.5;                      ///< s from the onset.
  double centring_sd = 0.001;                 ///< m, where the hand rests, per trial and axis.
  double encoder_counts = 8000.0;             ///< A revolution; 0: not quantised.
  double force_noise = 0.05;                  ///< N, one standard deviation, white.
  double force_resolution = 0.011;            ///< N; 0: not quantised.
  Eigen::Vector2d hand_in_robot{0.10, 0.45};  ///< m, where in the robot's frame the posture lies.
};

/// A gentler ramp, whose command is recorded.
[[nodiscard]] SimulatedRig rig_with_command();

/// A light, stiff rig whose controller follows the command's rate as well, and low noise.
[[nodiscard]] SimulatedRig rig_that_follows_its_command();

/// Without any sensor error: what remains is the method's own error.
[[nodiscard]] SimulatedRig ideal_rig();

/// The arm used throughout, upper arm 0.30 m and forearm 0.35 m, at a hand position in S (m).
[[nodiscard]] ArmModel typical_arm();
[[nodiscard]] SimulatedArm typical_subject(const Eigen::Vector2d& position = {0.0, 0.38});

/// The five published positions in S (m), reference, distal, proximal, right, left.
[[nodiscard]] const std::vector<Eigen::Vector2d>& published_positions();

/// Directions (rad) of `sets` full sets of eight.
[[nodiscard]] std::vector<double> directions(int sets = 2);

/// Geometry that a SimulatedRig's raw samples are converted with.
[[nodiscard]] RigGeometry geometry_of(const SimulatedRig& rig);
[[nodiscard]] ShoulderPose shoulder_of(const SimulatedRig& rig);

/// One perturbation as the hardware gives it: counts and volts, `rest` then `duration`. Same seed, same
/// samples.
struct RawTrial {
  std::vector<RawSample> samples;
  std::vector<Eigen::Vector2d> commanded;  ///< m, in S.
  Eigen::Index onset = 0;
};
[[nodiscard]] RawTrial simulate_raw(const SimulatedArm& arm, const SimulatedRig& rig, double direction,
                                    std::uint64_t seed);

/// The same, converted.
[[nodiscard]] std::vector<EndpointSample> convert_all(const SimulatedRig& rig,
                                                      const std::vector<RawSample>& raw);

/// A condition: one prepared trial per direction, numbered from 1.
[[nodiscard]] std::vector<Trial> simulate(const SimulatedArm& arm, const SimulatedRig& rig,
                                          const std::vector<double>& directions, std::uint64_t seed,
                                          bool is_force_tared = true);

/// Largest error of an element, as a share of the largest element of the truth.
[[nodiscard]] double relative_error(const Eigen::MatrixXd& estimate, const Eigen::MatrixXd& truth);

}  // namespace tonus::impedance::test
