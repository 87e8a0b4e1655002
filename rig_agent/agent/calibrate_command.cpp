#include "rig_agent/agent/calibrate_command.hpp"

#include <CLI/CLI.hpp>
#include <cmath>
#include <numbers>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "rig_agent/calibration/measure.hpp"

namespace tonus::rig {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
constexpr std::size_t kLoadsNeeded = 4;

calibration::Signature signature(const CalibrateOptions& options, const Clock& clock) {
  return {iso8601(clock.utc_ns()), options.by};
}

Result<calibration::RestReading> rest_reading(Rig& rig, const CalibrateOptions& options) {
  calibration::Cycles cycles(rig.driver(), rig.loop().period());
  return calibration::read_at_rest(rig.driver(), cycles, options.time);
}

Eigen::Vector2d joint_angles(const RigGeometry& geometry, const calibration::RestReading& reading) {
  RawSample raw;
  raw.encoder_count = reading.encoder_count;
  return joint_coordinates(geometry, raw);
}

/// A check of the command line: empty, or what is wrong.
std::string is_short_name(const std::string& name) {
  constexpr std::size_t kLongest = calibration::Calibration::kLongestName;
  return name.size() <= kLongest
             ? ""
             : fmt::format("{} bytes are not allowed; expected at most {}", name.size(), kLongest);
}

std::string matrix_text(const Eigen::Matrix2d& m) {
  return fmt::format("[{:.5g} {:.5g}; {:.5g} {:.5g}]", m(0, 0), m(0, 1), m(1, 0), m(1, 1));
}

}  // namespace

Result<std::string> tare(Rig& rig, const RigFolder& folder, const CalibrateOptions& options,
                         const Clock& clock) {
  const auto reading = rest_reading(rig, options);
  if (!reading) return reading.error();
  calibration::Calibration calibration = rig.calibration();
  calibration.set_tare(*reading, signature(options, clock));
  if (auto saved = calibration.save(folder.calibration()); !saved) return saved.error();
  return fmt::format("tare: offset {:.5f} V, {:.5f} V; noise {:.5f} V, {:.5f} V; {} samples",
                     reading->volts.x(), reading->volts.y(), reading->volts_deviation.x(),
                     reading->volts_deviation.y(), reading->samples);
}

Result<std::string> find_zero(Rig& rig, const RigFolder& folder, const CalibrateOptions& options,
                              const Clock& clock) {
  const RigGeometry& geometry = rig.driver().geometry();
  if (options.place.empty() == options.joints.empty())
    return fail(ErrorCode::kInvalidArgument, "either --at-m or --joints-deg is needed");
  Eigen::Vector2d angles;
  if (options.place.empty()) {
    angles = kRadiansPerDegree * Eigen::Vector2d(options.joints[0], options.joints[1]);
  } else {
    const Eigen::Vector2d place(options.place[0], options.place[1]);
    if (!geometry.links.reaches(place)) {
      return fail(
          ErrorCode::kInvalidArgument,
          fmt::format("--at-m: {} {} is not allowed; expected a place that the links of {} m and {} m reach",
                      place.x(), place.y(), geometry.links.l1, geometry.links.l2));
    }
    angles = geometry.links.angles_at(place);
  }
  const auto reading = rest_reading(rig, options);
  if (!reading) return reading.error();
  // angle = sign (count - zero) / counts per rad, solved for zero.
  std::array<double, 2> zero{};
  for (std::size_t i = 0; i < 2; ++i) {
    zero[i] = reading->encoder_count[i] -
              geometry.encoder_sign[i] * geometry.counts_per_unit[i] * angles[static_cast<Eigen::Index>(i)];
  }
  calibration::Calibration calibration = rig.calibration();
  calibration.set_zero(*reading, geometry.links.endpoint(angles), zero, signature(options, clock));
  if (auto saved = calibration.save(folder.calibration()); !saved) return saved.error();
  return fmt::format("zero: counts {:.1f} and {:.1f} at joint angle 0; were {:.1f} and {:.1f}", zero[0],
                     zero[1], geometry.encoder_zero[0], geometry.encoder_zero[1]);
}

Result<std::string> calibrate_force(Rig& rig, const RigFolder& folder, const CalibrateOptions& options,
                                    const Clock& clock) {
  const auto reading = rest_reading(rig, options);
  if (!reading) return reading.error();
  const RigGeometry& geometry = rig.driver().geometry();
  const auto signed_by = signature(options, clock);
  calibration::Calibration calibration = rig.calibration();
  if (options.is_anew) calibration.forget_loads();
  const double angle = joint_angles(geometry, *reading).sum() + geometry.force_sensor_angle;
  if (auto added =
          calibration.add_load({{options.load[0], options.load[1]}, reading->volts, angle}, signed_by);
      !added)
    return added.error();

  std::vector<calibration::KnownForce> forces;
  for (const auto& load : calibration.loads()) forces.push_back(load.known_force());
  std::string line = fmt::format("force: load {} of {:.4g} N, {:.4g} N taken", forces.size(), options.load[0],
                                 options.load[1]);
  if (forces.size() < kLoadsNeeded) {
    line +=
        fmt::format("; {} or more, in other directions, make a calibration", kLoadsNeeded - forces.size());
  } else if (const auto fit = calibration::fit_force(forces)) {
    calibration.set_force(*fit, signed_by);
    line += fmt::format("; in force: {} N/V, offset {:.5f} V, {:.5f} V, residual {:.3g} N",
                        matrix_text(fit->matrix), fit->offset.x(), fit->offset.y(), fit->residual);
  } else {
    line += "; not yet a calibration: " + fit.error().message;
  }
  if (auto saved = calibration.save(folder.calibration()); !saved) return saved.error();
  return line;
}

Result<std::string> check_spring(Rig& rig, const RigFolder& folder, const CalibrateOptions& options,
                                 const Clock& clock) {
  calibration::Cycles cycles(rig.driver(), rig.loop().period());
  calibration::SpringPlan plan;
  plan.place = rig.names().home;
  const auto steps = calibration::step_against_spring(rig.loop(), rig.driver().geometry(), cycles, plan);
  if (!steps) return steps.error();
  const auto fit = calibration::fit_spring(*steps);
  if (!fit) return fit.error();
  calibration::SpringCheck check;
  check.fit = *fit;
  check.steps = steps->size();
  check.nominal = options.nominal;
  check.measured = options.direction ? fit->along(*options.direction * kRadiansPerDegree) : fit->mean();
  check.direction = options.direction ? fmt::format("{} deg", *options.direction) : "all";
  calibration::Calibration calibration = rig.calibration();
  calibration.set_spring(check, signature(options, clock));
  if (auto saved = calibration.save(folder.calibration()); !saved) return saved.error();
  const std::string line =
      fmt::format("spring: {:.5g} N/m ({}), nominal {:.5g} N/m, {:+.2f} %; matrix {} N/m, residual {:.3g} N",
                  check.measured, check.direction, check.nominal, check.deviation_percent(),
                  matrix_text(fit->stiffness), fit->residual);
  if (std::abs(check.deviation_percent()) <= options.tolerance_percent) return line;
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("{}; expected at most {} %", line, options.tolerance_percent));
}

void add_calibrate_command(CLI::App& app, CalibrateOptions& options, CalibrationStep& chosen) {
  auto* command = app.add_subcommand("calibrate", "Calibrates or checks the rig, while no agent runs on it.");
  command->fallthrough();
  command->require_subcommand(1);
  const auto add = [&](const char* name, const char* what, CalibrationStep step) {
    auto* sub = command->add_subcommand(name, what);
    sub->fallthrough();
    sub->add_option("--operator", options.by, "who does it; kept with the result")
        ->required()
        ->check(is_short_name);
    sub->callback([&chosen, step = std::move(step)] { chosen = step; });
    return sub;
  };
  const auto add_time = [&](CLI::App* sub) {
    sub->add_option("--seconds", options.time, "time that is averaged")
        ->check(CLI::Range(0.1, 60.0))
        ->capture_default_str();
  };
  add_time(add("tare", "Offset of the force sensor; nothing touches the handle.", tare));

  auto* zero = add("zero", "Zero of the encoders; the handle is held at a known place.", find_zero);
  add_time(zero);
  zero->add_option("--at-m", options.place, "handle's place in the robot's frame, x y")->expected(2);
  zero->add_option("--joints-deg", options.joints, "or the joints' angles")->expected(2);

  auto* force =
      add("force", "One known weight on the handle; four or more make a calibration.", calibrate_force);
  add_time(force);
  force->add_option("--load-N", options.load, "pull of the weight on the handle in the robot's frame, x y")
      ->expected(2)
      ->required();
  force->add_flag("--anew", options.is_anew, "forget the loads taken before");

  auto* spring =
      add("spring", "Identifies a spring fixed to the handle and compares it with its nominal stiffness.",
          check_spring);
  spring->add_option("--nominal-N-per-m", options.nominal, "of the spring")
      ->check(CLI::Range(1.0, 1e5))
      ->required();
  spring->add_option("--direction-deg", options.direction, "along which it acts; without: alike in all");
  spring->add_option("--tolerance-percent", options.tolerance_percent, "beyond which the check fails")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
}

}  // namespace tonus::rig
