#include "analysis_service/certify/drawn_session.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

#include "analysis_service/certify/imperfect_arm.hpp"
#include "analysis_service/certify/own_force.hpp"
#include "services/mechanics/two_link.hpp"

namespace tonus::certify {
namespace {

constexpr int kStepsPerSample = 5;
constexpr double kSettling = 1.5;  // s before the rest, for motion under the disturbance to become stationary
constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr double kEncoderStep = kTwoPi / 8000.0;

const std::array<Eigen::Vector2d, 5> kPostures{Eigen::Vector2d{0.0, 0.38}, Eigen::Vector2d{0.0, 0.52},
                                               Eigen::Vector2d{0.0, 0.24}, Eigen::Vector2d{0.295, 0.38},
                                               Eigen::Vector2d{-0.295, 0.38}};

double between(double low, double high, std::mt19937_64& random) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Symmetric, eigenvalues drawn around `middle`, turned at random.
Eigen::Matrix2d drawn_matrix(double middle, double spread, std::mt19937_64& random) {
  const Eigen::Rotation2Dd turn(between(0.0, std::numbers::pi, random));
  const Eigen::Vector2d values(middle * (1.0 + between(-spread, spread, random)),
                               middle * (1.0 + between(-spread, spread, random)));
  return turn.toRotationMatrix() * values.asDiagonal() * turn.toRotationMatrix().transpose();
}

/// z+ = E z + G1 u + G2 (u+ - u) of z = [x; x'], u = [xc; d]: exact for straight inputs.
struct Step {
  Eigen::Matrix4d E;
  Eigen::Matrix4d G1;
  Eigen::Matrix4d G2;
};

Step step_of(const Truth& truth, const Eigen::Matrix2d& inverse_mass, double h) {
  Eigen::Matrix<double, 12, 12> held = Eigen::Matrix<double, 12, 12>::Zero();
  held.block<2, 2>(0, 2) = h * Eigen::Matrix2d::Identity();
  held.block<2, 2>(2, 0) = -h * inverse_mass * (truth.arm.K + truth.rig_stiffness);
  held.block<2, 2>(2, 2) = -h * inverse_mass * (truth.arm.B + truth.rig_damping);
  held.block<2, 2>(2, 4) = h * inverse_mass * truth.rig_stiffness;
  held.block<2, 2>(2, 6) = h * inverse_mass;
  held.block<4, 4>(4, 8) = Eigen::Matrix4d::Identity();
  const Eigen::Matrix<double, 12, 12> step = held.exp();
  return {step.block<4, 4>(0, 0), step.block<4, 4>(0, 4), step.block<4, 4>(0, 8)};
}

/// Rounds the rig's joints down, from wherever they stand.
void round_to_steps(Eigen::MatrixXd& x, const Eigen::Matrix2d& jacobian, double step,
                    std::mt19937_64& random) {
  const Eigen::Matrix2d to_joints = jacobian.inverse();
  const Eigen::Vector2d phase(between(0.0, 1.0, random), between(0.0, 1.0, random));
  for (Eigen::Index k = 0; k < x.rows(); ++k) {
    const Eigen::Vector2d counts = to_joints * x.row(k).transpose() / step + phase;
    x.row(k) = (step * jacobian * (counts.array().floor().matrix() - phase)).transpose();
  }
}

void add_noise(Eigen::MatrixXd& signal, double deviation, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0.0, 1.0);
  for (double& value : signal.reshaped()) value += deviation * normal(random);
}

}  // namespace

const std::vector<Setting>& settings() {
  static const std::vector<Setting> all = {
      {"white", {}, {}},
      {"encoder", {0.05, 0.0, kEncoderStep}, {}},
      {"living", {}, {0.2, 2.0, 0.1, 9.0, 1.5}},
  };
  return all;
}

Truth draw_truth(int posture, std::mt19937_64& random) {
  const auto& position = kPostures[static_cast<std::size_t>(posture % 5)];
  impedance::ArmModel arm{{between(1.4, 2.5, random), between(0.29, 0.34, random), 0.045},
                          {between(1.2, 1.8, random), between(0.33, 0.37, random), 0.035}};
  const impedance::JointImpedance stiffness{between(14.0, 34.0, random), between(10.0, 28.0, random),
                                            between(4.0, 12.0, random)};
  const impedance::JointImpedance damping{between(0.6, 2.0, random), between(0.4, 1.2, random),
                                          between(0.1, 0.5, random)};
  Truth truth;
  truth.arm = impedance::forward_model(arm, stiffness, damping, position).value();
  const double mass = between(6.0, 10.0, random);
  truth.rig_mass = drawn_matrix(mass, 0.2, random);
  truth.rig_damping = drawn_matrix(between(15.0, 40.0, random), 0.2, random);
  truth.rig_stiffness = drawn_matrix(between(1600.0, 2800.0, random), 0.2, random);
  const TwoLink rig{0.30, 0.35};
  truth.rig_jacobian = rig.jacobian(rig.angles_at({0.10, 0.45}));
  return truth;
}

Eigen::Vector2d target_of(const Design& design, int number) {
  const double direction = 0.25 * std::numbers::pi * (number % 8);
  return design.amplitude * Eigen::Vector2d(std::cos(direction), std::sin(direction));
}

Motion simulate_motion(const Truth& truth, const Design& design, const Disturbance& disturbance,
                       const Eigen::Vector2d& target, std::mt19937_64& random) {
  const auto rest = static_cast<Eigen::Index>(std::llround(design.rest / design.sample_period));
  const auto rows = rest + static_cast<Eigen::Index>(std::llround(design.window / design.sample_period));
  const double h = design.sample_period / kStepsPerSample;
  const Eigen::Matrix2d inverse_mass = (truth.arm.M + truth.rig_mass).inverse();
  const Step step = step_of(truth, inverse_mass, h);
  OwnForce own(disturbance, h, random);
  const auto command = [&](double t) -> Eigen::Vector2d {
    return std::clamp(t / std::max(design.rise, h), 0.0, 1.0) * target;
  };
  Motion motion{Eigen::MatrixXd(rows, 2), Eigen::MatrixXd(rows, 2), Eigen::MatrixXd(rows, 2),
                Eigen::MatrixXd(rows, 2), Eigen::MatrixXd(rows, 2)};
  const bool is_disturbed = disturbance.drift > 0.0 || disturbance.tremor > 0.0;
  Eigen::Index k = is_disturbed ? -std::llround(kSettling / design.sample_period) : 0;
  Eigen::Vector4d u = Eigen::Vector4d::Zero();
  u.tail<2>() = own.next();
  Eigen::Vector4d z = Eigen::Vector4d::Zero();
  z.head<2>() = (truth.arm.K + truth.rig_stiffness).inverse() * u.tail<2>();
  for (; k < rows; ++k) {
    const double t = static_cast<double>(k - rest) * design.sample_period;
    if (k >= 0) {
      const Eigen::Vector2d x = z.head<2>();
      const Eigen::Vector2d v = z.tail<2>();
      const Eigen::Vector2d d = u.tail<2>();
      const Eigen::Vector2d a =
          inverse_mass * (truth.rig_stiffness * (command(t) - x) - truth.rig_damping * v - truth.arm.B * v -
                          truth.arm.K * x + d);
      motion.x.row(k) = x.transpose();
      motion.velocity.row(k) = v.transpose();
      motion.acceleration.row(k) = a.transpose();
      motion.force.row(k) = (truth.arm.M * a + truth.arm.B * v + truth.arm.K * x - d).transpose();
      motion.commanded.row(k) = command(t).transpose();
    }
    for (int i = 1; i <= kStepsPerSample; ++i) {
      Eigen::Vector4d next;
      next << command(t + i * h), own.next();
      z = (step.E * z + step.G1 * u + step.G2 * (next - u)).eval();
      u = next;
    }
  }
  return motion;
}

impedance::Trial simulate_trial(const Truth& truth, const Design& design, const Setting& setting,
                                const Eigen::Vector2d& target, std::uint32_t number,
                                std::mt19937_64& random) {
  Motion motion = setting.error.is_none()
                      ? simulate_motion(truth, design, setting.disturbance, target, random)
                      : simulate_imperfect(truth, design, setting.disturbance, setting.error, target, random);
  add_noise(motion.force, setting.sensors.force_noise, random);
  add_noise(motion.x, setting.sensors.displacement_noise, random);
  if (setting.sensors.encoder_step > 0.0)
    round_to_steps(motion.x, truth.rig_jacobian, setting.sensors.encoder_step, random);
  impedance::Trial trial;
  trial.number = number;
  trial.sample_period = design.sample_period;
  trial.onset = std::llround(design.rest / design.sample_period);
  trial.displacement = std::move(motion.x);
  trial.force = std::move(motion.force);
  trial.commanded = std::move(motion.commanded);
  impedance::tare(trial, true);
  return trial;
}

std::vector<impedance::Trial> simulate_condition(const Truth& truth, const Design& design,
                                                 const Setting& setting, std::mt19937_64& random) {
  std::vector<impedance::Trial> trials;
  trials.reserve(static_cast<std::size_t>(design.trials));
  for (int number = 0; number < design.trials; ++number)
    trials.push_back(simulate_trial(truth, design, setting, target_of(design, number),
                                    static_cast<std::uint32_t>(number + 1), random));
  return trials;
}

}  // namespace tonus::certify
