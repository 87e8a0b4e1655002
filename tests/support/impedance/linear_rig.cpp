#include "tests/support/impedance/linear_rig.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace tonus::impedance::test {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// Force of given root mean square from sines of random phase, evenly spread over a band.
class BandForce {
 public:
  BandForce(double low, double high, double rms, std::mt19937_64& random)
      : amplitude_(rms * std::sqrt(2.0 / kSines)) {
    std::uniform_real_distribution<double> share(0.0, 1.0);
    for (int i = 0; i < kSines; ++i) {
      frequency_[static_cast<std::size_t>(i)] = low + (high - low) * (i + share(random)) / kSines;
      for (auto& phase : phase_) phase[static_cast<std::size_t>(i)] = kTwoPi * share(random);
    }
  }

  [[nodiscard]] Eigen::Vector2d at(double t) const {
    Eigen::Vector2d force = Eigen::Vector2d::Zero();
    if (amplitude_ == 0.0) return force;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      for (std::size_t i = 0; i < kSines; ++i) {
        force[static_cast<Eigen::Index>(axis)] +=
            amplitude_ * std::sin(kTwoPi * frequency_[i] * t + phase_[axis][i]);
      }
    }
    return force;
  }

 private:
  static constexpr int kSines = 12;
  double amplitude_;
  std::array<double, kSines> frequency_{};
  std::array<std::array<double, kSines>, 2> phase_{};
};

/// The coupled motion of handle and arm.
class Motion {
 public:
  Motion(const SimulatedArm& arm, const SimulatedRig& rig, double direction, std::mt19937_64& random)
      : arm_(arm),
        rig_(rig),
        toward_(std::cos(direction), std::sin(direction)),
        drift_(0.1, 1.0, arm.drift_rms, random),
        tremor_(8.0, 12.0, arm.tremor_rms, random),
        inverse_mass_((arm.impedance.M + rig.mass * Eigen::Matrix2d::Identity()).inverse()) {}

  [[nodiscard]] Eigen::Vector2d commanded(double t) const {
    const double u = std::clamp(t / std::max(rig_.rise, 1e-9), 0.0, 1.0);
    const double share = rig_.is_minimum_jerk ? u * u * u * (10.0 + u * (6.0 * u - 15.0)) : u;
    return rig_.amplitude * share * toward_;
  }

  /// Rate of commanded(), of a straight command none.
  [[nodiscard]] Eigen::Vector2d commanded_rate(double t) const {
    if (!rig_.is_minimum_jerk) return Eigen::Vector2d::Zero();
    const double u = std::clamp(t / rig_.rise, 0.0, 1.0);
    return rig_.amplitude * 30.0 * u * u * (1.0 - u) * (1.0 - u) / rig_.rise * toward_;
  }

  /// Force of the arm's model but for its inertia. The rig holds the spring's pull at rest, so that X = 0
  /// there.
  [[nodiscard]] Eigen::Vector2d resistance(double t) const {
    const Eigen::Vector3d products(v.x() * v.x(), v.x() * v.y(), v.y() * v.y());
    return arm_.impedance.B * v + arm_.impedance.K * (x - arm_.X0) + arm_.velocity_products * products +
           drift_.at(t) + tremor_.at(t);
  }

  [[nodiscard]] Eigen::Vector2d acceleration(double t) const {
    return inverse_mass_ *
           (rig_.stiffness * (commanded(t) - x) - rig_.damping * (v - rig_.rate_share * commanded_rate(t)) -
            arm_.impedance.K * arm_.X0 - resistance(t));
  }

  [[nodiscard]] Eigen::Vector2d force(double t) const {
    return arm_.impedance.M * acceleration(t) + resistance(t);
  }

  /// Classical Runge-Kutta step from t to t + h.
  void step(double t, double h) {
    const Eigen::Vector2d x0 = x;
    const Eigen::Vector2d v0 = v;
    const auto slope_at = [&](double time, const Eigen::Vector2d& dx, const Eigen::Vector2d& dv) {
      x = x0 + dx;
      v = v0 + dv;
      return std::pair<Eigen::Vector2d, Eigen::Vector2d>(v, acceleration(time));
    };
    const auto [x1, v1] = slope_at(t, Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero());
    const auto [x2, v2] = slope_at(t + 0.5 * h, 0.5 * h * x1, 0.5 * h * v1);
    const auto [x3, v3] = slope_at(t + 0.5 * h, 0.5 * h * x2, 0.5 * h * v2);
    const auto [x4, v4] = slope_at(t + h, h * x3, h * v3);
    x = x0 + h / 6.0 * (x1 + 2.0 * x2 + 2.0 * x3 + x4);
    v = v0 + h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
  }

  Eigen::Vector2d x = Eigen::Vector2d::Zero();
  Eigen::Vector2d v = Eigen::Vector2d::Zero();

 private:
  const SimulatedArm& arm_;
  const SimulatedRig& rig_;
  Eigen::Vector2d toward_;
  BandForce drift_;
  BandForce tremor_;
  Eigen::Matrix2d inverse_mass_;
};

double to_step(double value, double step) { return step > 0.0 ? step * std::round(value / step) : value; }

}  // namespace

SimulatedRig rig_with_command() {
  SimulatedRig rig;
  rig.rise = 0.1;
  rig.is_command_recorded = true;
  return rig;
}

SimulatedRig rig_that_follows_its_command() {
  SimulatedRig rig;
  rig.mass = 1.0;
  rig.damping = 150.0;
  rig.stiffness = 4000.0;
  rig.rise = 0.15;
  rig.is_minimum_jerk = true;
  rig.rate_share = 1.0;
  rig.is_command_recorded = true;
  rig.encoder_counts = 1e6;  // steps of 2 um
  rig.force_noise = 0.01;
  rig.force_resolution = 0.001;
  return rig;
}

SimulatedRig ideal_rig() {
  SimulatedRig rig;
  rig.centring_sd = 0.0;
  rig.encoder_counts = 0.0;
  rig.force_noise = 0.0;
  rig.force_resolution = 0.0;
  return rig;
}

ArmModel typical_arm() { return {{1.8, 0.30, 0.045}, {1.5, 0.35, 0.035}}; }

SimulatedArm typical_subject(const Eigen::Vector2d& position) {
  SimulatedArm subject;
  subject.impedance = forward_model(typical_arm(), {20.0, 15.0, 6.0}, {1.3, 0.85, 0.25}, position).value();
  return subject;
}

const std::vector<Eigen::Vector2d>& published_positions() {
  static const std::vector<Eigen::Vector2d> positions = {
      {0.0, 0.38}, {0.0, 0.52}, {0.0, 0.24}, {0.295, 0.38}, {-0.295, 0.38}};
  return positions;
}

std::vector<double> directions(int sets) {
  std::vector<double> all;
  for (int i = 0; i < 8 * sets; ++i) all.push_back(0.25 * std::numbers::pi * (i % 8));
  return all;
}

RigGeometry geometry_of(const SimulatedRig& rig) {
  RigGeometry geometry;
  const double counts = (rig.encoder_counts > 0.0 ? rig.encoder_counts : 8000.0) / kTwoPi;
  geometry.counts_per_unit = {counts, counts};
  geometry.force_sensor_angle = 0.3;
  return geometry;
}

ShoulderPose shoulder_of(const SimulatedRig& rig) {
  return {rig.hand_in_robot - Eigen::Vector2d(0.0, 0.38), 0.0};
}

RawTrial simulate_raw(const SimulatedArm& arm, const SimulatedRig& rig, double direction,
                      std::uint64_t seed) {
  constexpr int kStepsPerSample = 10;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Motion motion(arm, rig, direction, random);
  const RigGeometry geometry = geometry_of(rig);
  const Eigen::Vector2d centre =
      rig.hand_in_robot + rig.centring_sd * Eigen::Vector2d(normal(random), normal(random));
  const Eigen::Matrix2d volts_per_newton = geometry.force_calibration.inverse();

  RawTrial trial;
  trial.onset = std::llround(rig.rest / rig.sample_period);
  const auto samples = trial.onset + std::llround(rig.duration / rig.sample_period);
  const double h = rig.sample_period / kStepsPerSample;
  for (Eigen::Index k = 0; k < samples; ++k) {
    const double t = static_cast<double>(k - trial.onset) * rig.sample_period;
    const Eigen::Vector2d q = geometry.links.angles_at(centre + motion.x);
    Eigen::Vector2d force = motion.force(t);
    if (rig.force_noise > 0.0) force += rig.force_noise * Eigen::Vector2d(normal(random), normal(random));
    const double turn = q[0] + q[1] + geometry.force_sensor_angle;
    const Eigen::Vector2d in_sensor(std::cos(turn) * force.x() + std::sin(turn) * force.y(),
                                    -std::sin(turn) * force.x() + std::cos(turn) * force.y());
    RawSample raw;
    raw.acquisition_ns = std::llround(1e9 * static_cast<double>(k) * rig.sample_period) + 1;
    for (std::size_t i = 0; i < 2; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      raw.encoder_count[i] =
          to_step(q[axis] * geometry.counts_per_unit[i], rig.encoder_counts > 0.0 ? 1.0 : 0.0);
      raw.force_V[i] = volts_per_newton(axis, axis) * to_step(in_sensor[axis], rig.force_resolution);
    }
    trial.samples.push_back(raw);
    trial.commanded.push_back(motion.commanded(t));
    for (int i = 0; i < kStepsPerSample; ++i) motion.step(t + i * h, h);
  }
  return trial;
}

std::vector<EndpointSample> convert_all(const SimulatedRig& rig, const std::vector<RawSample>& raw) {
  const RigGeometry geometry = geometry_of(rig);
  const ShoulderPose shoulder = shoulder_of(rig);
  std::vector<EndpointSample> samples;
  for (const RawSample& sample : raw) samples.push_back(convert(geometry, shoulder, sample));
  return samples;
}

std::vector<Trial> simulate(const SimulatedArm& arm, const SimulatedRig& rig,
                            const std::vector<double>& directions, std::uint64_t seed, bool is_force_tared) {
  Preparation preparation;
  preparation.sample_period = rig.sample_period;
  preparation.rest = rig.rest;
  preparation.is_force_tared = is_force_tared;
  std::vector<Trial> trials;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const auto number = static_cast<std::uint32_t>(i + 1);
    const RawTrial raw = simulate_raw(arm, rig, directions[i], 1000 * seed + number);
    trials.push_back(prepare_trial(number, convert_all(rig, raw.samples), raw.onset, preparation,
                                   rig.is_command_recorded ? raw.commanded : std::vector<Eigen::Vector2d>{})
                         .value());
  }
  return trials;
}

double relative_error(const Eigen::MatrixXd& estimate, const Eigen::MatrixXd& truth) {
  return (estimate - truth).cwiseAbs().maxCoeff() / truth.cwiseAbs().maxCoeff();
}

}  // namespace tonus::impedance::test
