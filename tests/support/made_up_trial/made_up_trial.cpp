#include "tests/support/made_up_trial/made_up_trial.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tonus::identification::testing {
namespace {

constexpr double kRise = 0.2;  // s

/// Minimum-jerk step from 0 to 1 over kRise, and its first two derivatives.
struct Step {
  double value = 0.0;
  double rate = 0.0;
  double acceleration = 0.0;

  explicit Step(double t) {
    if (t <= 0.0) return;
    value = 1.0;
    if (t >= kRise) return;
    const double s = t / kRise;
    value = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
    rate = 30.0 * s * s * (1.0 - s) * (1.0 - s) / kRise;
    acceleration = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (kRise * kRise);
  }
};

struct Part {
  Phase phase;
  double duration;  // s
};

std::vector<Part> parts_of(const Recipe& recipe) {
  std::vector<Part> parts{{Phase::kCentring, 0.2}, {Phase::kWaiting, 1.0}};
  if (recipe.bias != Eigen::Vector2d::Zero()) {
    parts.push_back({Phase::kBiasRamp, 0.5});
    parts.push_back({Phase::kBiasHold, 1.0});
  }
  parts.push_back({Phase::kPerturbing, 1.75});
  parts.push_back({Phase::kReturning, 0.3});
  return parts;
}

}  // namespace

RigGeometry made_up_rig() {
  RigGeometry rig;
  rig.encoder_zero = {120.0, -40.0};
  rig.encoder_sign = {1.0, -1.0};
  rig.force_calibration << 4.45, 0.1, -0.05, 4.40;
  rig.force_offset_V << 0.02, -0.03;
  rig.force_sensor_angle = 0.3;
  return rig;
}

RawSample raw_of(const RigGeometry& rig, const ShoulderPose& shoulder, const Eigen::Vector2d& p_SE,
                 const Eigen::Vector2d& f_S) {
  RawSample raw;
  Eigen::Vector2d q = p_SE;
  Eigen::Vector2d f = f_S;
  if (rig.kind == RigKind::kTwoLink) {
    const Eigen::Rotation2Dd to_robot(shoulder.angle);
    q = rig.links.angles_at(shoulder.origin + to_robot * p_SE);
    f = Eigen::Rotation2Dd(q[0] + q[1] + rig.force_sensor_angle).inverse() * (to_robot * f_S);
  }
  const Eigen::Vector2d volts = rig.force_calibration.inverse() * f + rig.force_offset_V;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    raw.encoder_count[i] = rig.encoder_zero[i] + rig.encoder_sign[i] * rig.counts_per_unit[i] * q[axis];
    raw.force_V[i] = volts[axis];
  }
  return raw;
}

Id made_up_session() { return id_of("session"); }
Id made_up_rig_id() { return id_of("rig/rig"); }

MeasuredTrial made_up_trial(const Recipe& recipe) {
  MeasuredTrial trial;
  TrialReport& report = trial.report;
  TrialPlan& plan = report.plan;
  plan.trial = trial_id(made_up_session(), recipe.attempt);
  plan.session = made_up_session();
  plan.rig = made_up_rig_id();
  plan.attempt = recipe.attempt;
  plan.planned_index = recipe.attempt - 1;
  plan.posture = "reference";
  plan.posture_index = recipe.posture_index;
  plan.position = {0.0, 0.38};
  plan.shoulder = {{0.05, -0.10}, 0.1};
  plan.set = recipe.set;
  plan.bias = recipe.bias;
  plan.bias_hold = 1.0;
  plan.bias_threshold = 0.1;
  report.epoch = recipe.epoch;
  report.sample_rate = kRate;
  report.range.first = recipe.first_sequence;

  const auto parts = parts_of(recipe);
  double before_onset = 0.0;
  for (const Part& part : parts) {
    if (part.phase < Phase::kPerturbing) before_onset += part.duration;
  }
  const TrueArm arm;
  const double angle = recipe.direction_deg * std::numbers::pi / 180.0;
  const Eigen::Vector2d way = recipe.amplitude * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  double begun = -before_onset;
  for (const Part& part : parts) {
    const auto rows = static_cast<int>(std::lround(part.duration * kRate));
    for (int i = 0; i < rows; ++i) {
      const double t = begun + static_cast<double>(i) / kRate;
      const Step step(part.phase == Phase::kReturning ? 0.0 : t);
      Eigen::Vector2d position = plan.position + step.value * way;
      Eigen::Vector2d force = (arm.M * step.acceleration + arm.B * step.rate + arm.K * step.value) * way;
      if (part.phase == Phase::kBiasRamp)
        force += static_cast<double>(i) / static_cast<double>(rows) * recipe.bias;
      // On the way back too: the arm, again in its place, pushes as it did before.
      if (part.phase >= Phase::kBiasHold && part.phase <= Phase::kReturning) force += recipe.bias;
      if (recipe.added_way) position += recipe.added_way(t, part.phase);
      if (recipe.added_force) force += recipe.added_force(t, part.phase);
      Row row;
      row.raw = raw_of(recipe.rig, plan.shoulder, position, force);
      row.raw.acquisition_ns =
          5'000'000LL * static_cast<std::int64_t>(recipe.first_sequence + trial.rows.size());
      row.phase = part.phase;
      if (part.phase == Phase::kPerturbing) {
        if (report.onset == 0) report.onset = recipe.first_sequence + trial.rows.size();
        row.commanded = {way.x(), way.y()};
      }
      trial.rows.push_back(row);
    }
    begun += part.duration;
  }
  report.range.end = recipe.first_sequence + trial.rows.size();
  return trial;
}

std::vector<RowBlock> blocks_of(const MeasuredTrial& trial, std::size_t rows_a_block) {
  std::vector<RowBlock> blocks;
  const std::span<const Row> rows = trial.rows;
  for (std::size_t first = 0; first < rows.size(); first += rows_a_block) {
    blocks.push_back({trial.report.plan.rig, trial.report.plan.trial, trial.report.epoch,
                      trial.report.range.first + first,
                      rows.subspan(first, std::min(rows_a_block, rows.size() - first))});
  }
  return blocks;
}

bool same_rows(const std::vector<Row>& a, const std::vector<Row>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Row& x, const Row& y) {
    return x.raw.acquisition_ns == y.raw.acquisition_ns && x.raw.encoder_count == y.raw.encoder_count &&
           x.raw.force_V == y.raw.force_V && x.commanded == y.commanded && x.phase == y.phase &&
           x.is_saturated == y.is_saturated && x.is_missing == y.is_missing;
  });
}

std::vector<MeasuredTrial> made_up_condition() {
  std::vector<MeasuredTrial> trials;
  for (std::uint32_t i = 0; i < 16; ++i) {
    Recipe recipe;
    recipe.attempt = i + 1;
    recipe.direction_deg = 45.0 * (i % 8);
    recipe.set = i < 8 ? 1 : 2;
    recipe.first_sequence = 1000 + 1000 * i;
    trials.push_back(made_up_trial(recipe));
  }
  return trials;
}

}  // namespace tonus::identification::testing
