#include "services/simulation/profile.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <spdlog/fmt/fmt.h>
#include <string>
#include <type_traits>

#include "rig_agent/control/setting_ranges.hpp"
#include "services/config/checked_table.hpp"
#include "services/config/toml_text.hpp"
#include "services/core/text_file.hpp"

namespace tonus::simulation {
namespace {

using config::CheckedTable;

void read(CheckedTable s, ManipulandumProfile& rig) {
  Eigen::Vector2d lengths(rig.links.l1, rig.links.l2);
  s.pair("link_lengths_m", lengths, 0.05, 2.0);
  rig.links = {lengths[0], lengths[1]};
  s.pair("link_masses_kg", rig.link_masses, 0.0, 50.0);
  s.pair("rotor_inertias_kg_m2", rig.rotor_inertias, 1e-4, 10.0);
  s.number("elbow_motor_mass_kg", rig.elbow_motor_mass, 0.0, 50.0);
  s.number("tip_mass_kg", rig.tip_mass, 0.0, 10.0);
  s.pair("viscous_friction_Nms_per_rad", rig.friction.viscous, 0.0, 10.0);
  s.pair("coulomb_friction_Nm", rig.friction.coulomb, 0.0, 5.0);
  s.number("coulomb_smoothing_rad_per_s", rig.friction.smoothing, 1e-3, 1.0);
  s.pair("torque_limits_Nm", rig.torque_limits, 0.1, 500.0);
  s.pair("motor_gains", rig.motor_gains, 0.0, 2.0);
  s.number("motor_time_constant_s", rig.motor_time_constant, 0.0, 0.1);
  s.pair("home_m", rig.home, -4.0, 4.0);
  s.finish();
}

void read(CheckedTable s, SensorProfile& sensors) {
  s.number("encoder_counts_per_rev", sensors.encoder_counts_per_rev, 100.0, 1e8);
  s.pair("encoder_zero_count", sensors.encoder_zero, -1e9, 1e9);
  s.number("force_full_scale_N", sensors.force_full_scale, 1.0, 5000.0);
  s.number("voltage_full_scale_V", sensors.voltage_full_scale, 0.1, 100.0);
  s.number("force_resolution_N", sensors.force_resolution, 0.0, 10.0);
  s.number("force_noise_N", sensors.force_noise, 0.0, 10.0);
  s.pair("force_offset_V", sensors.force_offset_V, -10.0, 10.0);
  s.number("force_sensor_angle_rad", sensors.force_sensor_angle, -std::numbers::pi, std::numbers::pi);
  s.number("handle_mass_kg", sensors.handle_mass, 0.0, 2.0);
  CheckedTable errors = s.optional_table("errors");
  errors.pair("zero_count", sensors.errors.zero_count, -1e6, 1e6);
  errors.pair("offset_V", sensors.errors.offset_V, -10.0, 10.0);
  errors.pair("force_row_x", sensors.errors.force_row_x, -10.0, 10.0);
  errors.pair("force_row_y", sensors.errors.force_row_y, -10.0, 10.0);
  errors.finish();
  s.finish();
}

void read(CheckedTable s, BenchProfile& bench) {
  s.flag("is_on", bench.is_on);
  s.flag("is_clamped", bench.is_clamped);
  s.pair("load_N", bench.load, -500.0, 500.0);
  s.pair("spring_N_per_m", bench.spring, 0.0, 5000.0);
  s.number("damping_Ns_per_m", bench.damping, 0.0, 500.0);
  s.finish();
}

void read(CheckedTable s, GripProfile& grip) {
  s.number("stiffness_N_per_m", grip.stiffness, 1e3, 2e6);
  s.number("damping_Ns_per_m", grip.damping, 0.0, 2e3);
  s.finish();
}

void read(CheckedTable s, JointImpedance& joints, double high) {
  s.number("shoulder", joints.shoulder, 0.0, high);
  s.number("elbow", joints.elbow, 0.0, high);
  s.number("two_joint", joints.two_joint, -high, high);
  s.finish();
}

void read(CheckedTable s, ReflexEffect& reflex) {
  s.flag("is_on", reflex.is_on);
  s.number("delay_s", reflex.delay, 0.005, 0.25);
  read(s.optional_table("stiffness_Nm_per_rad"), reflex.stiffness, 100.0);
  read(s.optional_table("damping_Nms_per_rad"), reflex.damping, 10.0);
  s.finish();
}

void read(CheckedTable s, TremorEffect& tremor) {
  s.flag("is_on", tremor.is_on);
  s.number("force_N", tremor.force, 0.0, 10.0);
  s.number("frequency_Hz", tremor.frequency, 1.0, 30.0);
  s.number("bandwidth_Hz", tremor.bandwidth, 0.05, 10.0);
  s.finish();
}

void read(CheckedTable s, DriftEffect& drift) {
  s.flag("is_on", drift.is_on);
  s.number("force_N", drift.force, 0.0, 10.0);
  s.number("time_constant_s", drift.time_constant, 0.05, 100.0);
  s.finish();
}

void read(CheckedTable s, ReactionEffect& reaction) {
  s.flag("is_on", reaction.is_on);
  s.number("probability", reaction.probability, 0.0, 1.0);
  s.number("latency_s", reaction.latency, 0.0, 2.0);
  s.number("rise_s", reaction.rise, 0.01, 2.0);
  s.number("force_N", reaction.force, 0.0, 50.0);
  s.number("threshold_m", reaction.threshold, 1e-4, 0.05);
  s.finish();
}

void read(CheckedTable s, FatigueEffect& fatigue) {
  s.flag("is_on", fatigue.is_on);
  s.number("depth", fatigue.depth, 0.0, 0.95);
  s.number("time_constant_s", fatigue.time_constant, 0.1, 1e5);
  s.finish();
}

void read(CheckedTable s, LettingGoEffect& letting_go) {
  s.flag("is_on", letting_go.is_on);
  s.number("at_s", letting_go.at, 0.0, 1e6);
  s.number("duration_s", letting_go.duration, 0.01, 1e6);
  s.finish();
}

void read(CheckedTable s, RecentringEffect& recentring) {
  s.flag("is_on", recentring.is_on);
  s.number("time_constant_s", recentring.time_constant, 0.05, 100.0);
  s.number("speed_m_per_s", recentring.speed, 1e-3, 1.0);
  s.number("pause_s", recentring.pause, 0.0, 10.0);
  s.finish();
}

void read(CheckedTable s, ModulationEffect& modulation) {
  s.flag("is_on", modulation.is_on);
  s.number("gain_per_N", modulation.gain, 0.0, 10.0);
  s.number("time_constant_s", modulation.time_constant, 0.05, 100.0);
  s.finish();
}

void read(CheckedTable s, MisconductEffect& misconduct) {
  constexpr std::uint64_t kMost = 1'000'000;
  s.flag("is_on", misconduct.is_on);
  s.counts("pushes_early_in_trials", misconduct.pushes_early, 1, kMost);
  s.counts("drifts_off_in_trials", misconduct.drifts_off, 1, kMost);
  s.counts("lets_go_in_trials", misconduct.lets_go, 1, kMost);
  s.counts("tenses_in_trials", misconduct.tenses, 1, kMost);
  s.number("after_s", misconduct.after, 0.0, 100.0);
  s.number("push_N", misconduct.push, 0.0, 50.0);
  s.number("push_period_s", misconduct.push_period, 0.05, 10.0);
  s.number("drift_m", misconduct.drift, -0.1, 0.1);
  s.number("drift_time_s", misconduct.drift_time, 0.1, 100.0);
  s.number("tension", misconduct.tension, 0.0, 1.0);
  s.number("grip_speed_m_per_s", misconduct.grip_speed, 1e-3, 1.0);
  s.number("grip_latency_s", misconduct.grip_latency, 0.0, 10.0);
  s.finish();
}

void read(CheckedTable s, InstructionEffect& instruction) {
  s.flag("is_on", instruction.is_on);
  s.number("relaxed", instruction.relaxed, 0.1, 1.0);
  s.number("stiffened", instruction.stiffened, 1.0, 5.0);
  s.finish();
}

void read(CheckedTable s, MuscleProfile& muscles) {
  s.number("rest", muscles.rest, 0.0, 0.5);
  s.number("per_stiffness", muscles.per_stiffness, 0.01, 1.0);
  CheckedTable strength = s.optional_table("strength_Nm");
  strength.number("shoulder", muscles.strength.shoulder, 1.0, 500.0);
  strength.number("elbow", muscles.strength.elbow, 1.0, 500.0);
  strength.number("two_joint", muscles.strength.two_joint, 1.0, 500.0);
  strength.finish();
  s.number("reflex", muscles.reflex, 0.0, 1.0);
  s.number("reflex_threshold_rad_per_s", muscles.reflex_threshold, 0.0, 1.0);
  s.number("contraction_latency_s", muscles.contraction_latency, 0.0, 2.0);
  s.number("contraction_rise_s", muscles.contraction_rise, 0.01, 2.0);
  s.number("emg_V", muscles.emg, 0.0, 1.0);
  s.number("noise_V", muscles.noise, 0.0, 1.0);
  s.finish();
}

AuxiliaryChannel read_auxiliary(CheckedTable s) {
  AuxiliaryChannel channel;
  channel.name = s.text("name", 1, 32);
  channel.type = s.one_of("type", auxiliary_types());
  channel.unit = s.text("unit", 1, 16);
  channel.rate = s.number("rate_Hz", {0.1, kMostAuxiliaryRate, "Hz"});
  channel.unit_per_value = s.number("unit_per_value", {-1e12, 1e12}, 1.0);
  s.finish();
  return channel;
}

void read(CheckedTable s, SubjectProfile& subject) {
  Eigen::Vector2d lengths(subject.links.l1, subject.links.l2);
  s.pair("link_lengths_m", lengths, 0.1, 0.6);
  subject.links = {lengths[0], lengths[1]};
  s.pair("link_masses_kg", subject.link_masses, 0.1, 20.0);
  s.pair("link_radii_m", subject.link_radii, 0.0, 0.15);
  s.pair("posture_m", subject.posture, -1.2, 1.2);
  read(s.optional_table("joint_stiffness_Nm_per_rad"), subject.stiffness, 1000.0);
  read(s.optional_table("joint_damping_Nms_per_rad"), subject.damping, 100.0);
  read(s.optional_table("reflex"), subject.reflex);
  read(s.optional_table("tremor"), subject.tremor);
  read(s.optional_table("drift"), subject.drift);
  read(s.optional_table("reaction"), subject.reaction);
  read(s.optional_table("fatigue"), subject.fatigue);
  read(s.optional_table("letting_go"), subject.letting_go);
  read(s.optional_table("recentring"), subject.recentring);
  read(s.optional_table("modulation"), subject.modulation);
  read(s.optional_table("misconduct"), subject.misconduct);
  read(s.optional_table("instruction"), subject.instruction);
  read(s.optional_table("muscles"), subject.muscles);
  s.finish();
}

/// Reads each setting of control/setting_ranges.hpp that it is called for.
auto reader_of(CheckedTable& s) {
  return [&s](const char* key, auto& value, auto low, auto high) {
    using Value = std::remove_reference_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, Eigen::Vector2d>) {
      s.pair(key, value, low, high);
    } else if constexpr (std::is_same_v<Value, unsigned>) {
      s.count(key, value, low, high);
    } else {
      s.number(key, value, low, high);
    }
  };
}

void read(CheckedTable s, control::SafetyLimits& limits) {
  control::for_each_limit(limits, reader_of(s));
  s.finish();
}

void read(CheckedTable s, control::ServoGains& gains) {
  control::for_each_gain(gains, reader_of(s));
  s.finish();
}

void read(CheckedTable s, Profile& profile) {
  CheckedTable simulation = s.optional_table("simulation");
  simulation.count("seed", profile.seed, std::uint64_t{0}, std::uint64_t{1} << 62);
  simulation.count("sub_steps", profile.sub_steps, 1, 1000);
  simulation.finish();
  CheckedTable loop = s.optional_table("loop");
  loop.number("rate_Hz", profile.loop_rate, 50.0, 4000.0);
  loop.count("sample_divider", profile.sample_divider, 1, 4000);
  loop.finish();
  read(s.optional_table("manipulandum"), profile.manipulandum);
  read(s.optional_table("sensors"), profile.sensors);
  read(s.optional_table("grip"), profile.grip);
  read(s.optional_table("subject"), profile.subject);
  read(s.optional_table("bench"), profile.bench);
  for (const CheckedTable& channel : s.tables("auxiliary", 0, kMostAuxiliaryChannels))
    profile.auxiliary.push_back(read_auxiliary(channel));
  read(s.optional_table("limits"), profile.limits);
  read(s.optional_table("control"), profile.gains);
  (void)s.has("agent");  // a rig's own file: the agent's options
  s.finish();
}

std::string point(const Eigen::Vector2d& p) { return fmt::format("[{}, {}]", p.x(), p.y()); }

std::string annulus(const TwoLink& links) {
  return fmt::format("a distance from {:.4g} to {:.4g} m, exclusive", std::abs(links.l1 - links.l2),
                     links.l1 + links.l2);
}

// What single values cannot show: points out of reach, matrices that are not positive definite, steps too
// large.
void check_together(const Profile& profile, config::Findings& findings) {
  const ManipulandumProfile& rig = profile.manipulandum;
  const SubjectProfile& subject = profile.subject;
  if (!rig.links.reaches(rig.home)) {
    findings.refuse("manipulandum.home_m", point(rig.home), annulus(rig.links));
  }
  if (!subject.links.reaches(subject.posture)) {
    findings.refuse("subject.posture_m", point(subject.posture), annulus(subject.links));
  }
  const control::SafetyLimits& limits = profile.limits;
  if (!((rig.home - limits.workspace_centre).norm() < limits.workspace_radius)) {
    findings.refuse(
        "manipulandum.home_m", point(rig.home),
        fmt::format("less than limits.workspace_radius_m = {} from limits.workspace_centre_m = {}",
                    limits.workspace_radius, point(limits.workspace_centre)));
  }
  const double sample_rate = profile.loop_rate / profile.sample_divider;
  if (const auto valid = validate(profile.auxiliary, sample_rate); !valid) {
    const auto line = findings.lines.find("auxiliary");
    findings.report(line == findings.lines.end() ? 0 : line->second, valid.error().message);
  }
  const auto check_matrix = [&](const char* key, const JointImpedance& joints) {
    if (joints.matrix().determinant() > 0.0 && joints.shoulder + joints.two_joint > 0.0) return;
    findings.refuse(key,
                    fmt::format("{{shoulder = {}, elbow = {}, two_joint = {}}}", joints.shoulder,
                                joints.elbow, joints.two_joint),
                    "values that make [[s + d, d], [d, e + d]] positive definite");
  };
  check_matrix("subject.joint_stiffness_Nm_per_rad", subject.stiffness);
  check_matrix("subject.joint_damping_Nms_per_rad", subject.damping);

  // Runge-Kutta resolves the grip's oscillation with 0.8 rad a step; the arm feels at least as heavy as this.
  const double lightest = 0.25 * subject.link_masses.minCoeff();
  const double sub_step = 1.0 / (profile.loop_rate * profile.sub_steps);
  const double angle =
      sub_step * std::max(std::sqrt(profile.grip.stiffness / lightest), profile.grip.damping / lightest);
  if (angle > 0.8) {
    findings.refuse("simulation.sub_steps", std::to_string(profile.sub_steps),
                    fmt::format("{:.0f} or more for this grip at {} Hz",
                                std::ceil(profile.sub_steps * angle / 0.8), profile.loop_rate));
  }
}

}  // namespace

Result<Profile> read_profile(const toml::table& table, const std::string& source) {
  config::Findings findings{source, {}, {}};
  Profile profile;
  read(CheckedTable(table, "", 0, findings), profile);
  if (!findings.problem) check_together(profile, findings);
  if (findings.problem) return fail(ErrorCode::kInvalidArgument, *findings.problem);
  return profile;
}

std::vector<config::Key> profile_keys() {
  return config::keys_of([](const CheckedTable& root, config::Findings&) {
    Profile profile;
    read(root, profile);
  });
}

Result<Profile> parse_profile(std::string_view text, std::string_view source) {
  const std::string name(source);
  TONUS_TRY_ASSIGN(const toml::table table, config::parse_toml(text, name));
  return read_profile(table, name);
}

Result<Profile> load_profile(const std::filesystem::path& file) {
  const auto text = read_text_file(file);
  if (!text) return fail(text.error().code, "profile " + text.error().message);
  return parse_profile(*text, file.string());
}

control::LoopConfig loop_config(const Profile& profile) {
  control::LoopConfig config;
  config.rate = profile.loop_rate;
  config.sample_divider = profile.sample_divider;
  config.limits = profile.limits;
  config.gains = profile.gains;
  config.model = manipulandum_model(profile.manipulandum, profile.sensors.handle_mass);
  return config;
}

}  // namespace tonus::simulation
