#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "analysis_service/impedance/arm_model.hpp"
#include "analysis_service/impedance/trial.hpp"

namespace tonus::certify {

/// What the sensors add. Displacement noise is white; an encoder step rounds each of the rig's joints down
/// instead.
struct Sensors {
  double force_noise = 0.05;           ///< N, one standard deviation, each axis.
  double displacement_noise = 6.8e-5;  ///< m: that of an encoder step of 0.236 mm, step/sqrt(12).
  double encoder_step = 0.0;           ///< rad; 0: no rounding.
};

/// The arm's own force on the handle, each axis: first-order Gauss-Markov drift and narrow-band tremor.
struct Disturbance {
  double drift = 0.0;             ///< N rms.
  double drift_time = 2.0;        ///< s.
  double tremor = 0.0;            ///< N rms.
  double tremor_frequency = 9.0;  ///< Hz.
  double tremor_bandwidth = 1.5;  ///< Hz, half width at half power.
};

/// How a condition is measured.
struct Design {
  int trials = 16;               ///< Balanced over eight directions.
  double amplitude = 0.005;      ///< m.
  double rise = 0.2;             ///< s, straight ramp of the command.
  double sample_period = 0.005;  ///< s.
  double rest = 0.5;             ///< s before the onset.
  double window = 1.0;           ///< s from the onset.
};

/// How an arm, or its grip, differs from M, B, K.
struct ModelError {
  double reflex = 0.0;  ///< Of K: the elastic force follows the displacement of `reflex_delay` ago, too.
  double reflex_delay = 0.04;  ///< s.
  double hardening = 0.0;      ///< Of K: by how much the secant stiffness rises to 5 mm, with the square.
  double slack = 0.0;     ///< m: the handle moves so far from the grip's centre before it meets the hand.
  double friction = 0.0;  ///< N, against the direction of the hand's velocity.

  [[nodiscard]] bool is_none() const {
    return reflex == 0.0 && hardening == 0.0 && slack == 0.0 && friction == 0.0;
  }
};

/// A named choice of all.
struct Setting {
  std::string name;
  Sensors sensors;
  Disturbance disturbance;
  ModelError error{};
};

/// "white": white noise on both sensors. "encoder": displacement rounded to encoder steps. "living": white,
/// and drift of 0.2 N and tremor of 0.1 N rms.
[[nodiscard]] const std::vector<Setting>& settings();

/// A subject at one of the five published postures on a rig that yields. All 2x2, in S.
struct Truth {
  impedance::CartesianImpedance arm;
  Eigen::Matrix2d rig_mass;
  Eigen::Matrix2d rig_damping;
  Eigen::Matrix2d rig_stiffness;
  Eigen::Matrix2d rig_jacobian;  ///< Of the joints that have the encoders.
};

/// Link lengths, masses, joint stiffness and damping of a relaxed adult, apparent mass, damping and stiffness
/// of the rig: each drawn evenly from its range. `posture`: 0 to 4.
[[nodiscard]] Truth draw_truth(int posture, std::mt19937_64& random);

/// Motion of handle and arm and the force between them, at the samples; exact for a command and a disturbance
/// that are straight between steps of a fifth of the sample period.
///
///     (M + Mr) x" = Kr (xc - x) - Br x' - B x' - K x + d        F = M x" + B x' + K x - d
struct Motion {
  Eigen::MatrixXd x;             ///< m, rows x 2.
  Eigen::MatrixXd velocity;      ///< m/s.
  Eigen::MatrixXd acceleration;  ///< m/s2.
  Eigen::MatrixXd force;         ///< N, on the arm.
  Eigen::MatrixXd commanded;     ///< m.
};

/// One trial towards `target` (m), without sensors.
[[nodiscard]] Motion simulate_motion(const Truth& truth, const Design& design, const Disturbance& disturbance,
                                     const Eigen::Vector2d& target, std::mt19937_64& random);

/// A trial as it would be measured, numbered from 1 and prepared as the service does it.
[[nodiscard]] impedance::Trial simulate_trial(const Truth& truth, const Design& design,
                                              const Setting& setting, const Eigen::Vector2d& target,
                                              std::uint32_t number, std::mt19937_64& random);

/// A condition as it would be measured: trials numbered from 1, prepared as the service does it.
[[nodiscard]] std::vector<impedance::Trial> simulate_condition(const Truth& truth, const Design& design,
                                                               const Setting& setting,
                                                               std::mt19937_64& random);

/// Where trial `number` (from 0) goes, m.
[[nodiscard]] Eigen::Vector2d target_of(const Design& design, int number);

}  // namespace tonus::certify
