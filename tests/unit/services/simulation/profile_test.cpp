#include "services/simulation/profile.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>
#include <string>

#include "rig_agent/control/validation.hpp"

namespace tonus::simulation {
namespace {

std::string refusal(const std::string& text) {
  const auto result = parse_profile(text, "mine.toml");
  return result ? "accepted" : result.error().message;
}

TEST(Profile, ReadsTheDefaultFileAsTheBuiltInDefaults) {
  const auto loaded = load_profile(TONUS_SOURCE_DIR "/deploy/profiles/default.toml");
  ASSERT_TRUE(loaded) << loaded.error().message;
  const Profile defaults;
  EXPECT_EQ(loaded->manipulandum.rotor_inertias, defaults.manipulandum.rotor_inertias);
  EXPECT_EQ(loaded->manipulandum.link_masses, defaults.manipulandum.link_masses);
  EXPECT_EQ(loaded->manipulandum.friction.coulomb, defaults.manipulandum.friction.coulomb);
  EXPECT_EQ(loaded->sensors.force_noise, defaults.sensors.force_noise);
  EXPECT_EQ(loaded->sensors.handle_mass, defaults.sensors.handle_mass);
  EXPECT_EQ(loaded->grip.stiffness, defaults.grip.stiffness);
  EXPECT_EQ(loaded->grip.damping, defaults.grip.damping);
  EXPECT_EQ(loaded->subject.stiffness.matrix(), defaults.subject.stiffness.matrix());
  EXPECT_EQ(loaded->subject.damping.matrix(), defaults.subject.damping.matrix());
  EXPECT_EQ(loaded->subject.link_masses, defaults.subject.link_masses);
  EXPECT_EQ(loaded->subject.recentring.time_constant, defaults.subject.recentring.time_constant);
  EXPECT_EQ(loaded->sub_steps, defaults.sub_steps);
  EXPECT_FALSE(loaded->bench.is_on);
  EXPECT_EQ(loaded->sensors.errors.force_row_y, defaults.sensors.errors.force_row_y);
  EXPECT_EQ(loaded->limits.force, defaults.limits.force);
  EXPECT_EQ(loaded->limits.torque, defaults.limits.torque);
  EXPECT_EQ(loaded->gains.perturbation_phase, defaults.gains.perturbation_phase);
  EXPECT_EQ(loaded->gains.perturbation_damping, defaults.gains.perturbation_damping);
  EXPECT_EQ(loaded->gains.float_damping, defaults.gains.float_damping);
  EXPECT_EQ(loaded->gains.force_trim, defaults.gains.force_trim);
}

TEST(Profile, HasSensorNoiseAloneByDefault) {
  const auto profile = parse_profile("", "empty");
  ASSERT_TRUE(profile);
  const SubjectProfile& s = profile->subject;
  EXPECT_FALSE(s.reflex.is_on || s.tremor.is_on || s.drift.is_on || s.reaction.is_on || s.fatigue.is_on ||
               s.letting_go.is_on || s.recentring.is_on || s.modulation.is_on || s.misconduct.is_on);
  EXPECT_EQ(profile->sensors.force_noise, 0.05);
  EXPECT_EQ(profile->sensors.encoder_counts_per_rev, 8000.0);
}

TEST(Profile, TakesListsOfTrialsAndRefusesOthers) {
  const auto profile = parse_profile("[subject.misconduct]\nlets_go_in_trials = [3, 17]\n", "mine.toml");
  ASSERT_TRUE(profile) << profile.error().message;
  EXPECT_EQ(profile->subject.misconduct.lets_go, (std::vector<std::uint64_t>{3, 17}));
  EXPECT_EQ(refusal("[subject.misconduct]\nlets_go_in_trials = [0]"),
            "mine.toml:2: subject.misconduct.lets_go_in_trials: [0] is not allowed; expected a list of whole "
            "numbers, each 1 to 1000000");
}

TEST(Profile, TakesWhatTheTextSaysAndKeepsTheRest) {
  const auto profile = parse_profile(R"(
    [simulation]
    seed = 7
    [subject]
    link_masses_kg = [1.8, 1]
    [subject.tremor]
    is_on = true
    force_N = 0.3
  )",
                                     "mine.toml");
  ASSERT_TRUE(profile) << profile.error().message;
  EXPECT_EQ(profile->seed, 7U);
  EXPECT_EQ(profile->subject.link_masses, Eigen::Vector2d(1.8, 1.0));
  EXPECT_TRUE(profile->subject.tremor.is_on);
  EXPECT_EQ(profile->subject.tremor.force, 0.3);
  EXPECT_EQ(profile->subject.tremor.frequency, TremorEffect{}.frequency);
}

TEST(Profile, NamesFileKeyValueAndLimitsOfWhatItRefuses) {
  EXPECT_EQ(refusal("[grip]\nstiffness_N_per_m = 3"),
            "mine.toml:2: grip.stiffness_N_per_m: 3 is not allowed; expected 1000 to 2000000");
  EXPECT_EQ(refusal("[sensors]\nforce_noise_N = \"low\""),
            "mine.toml:2: sensors.force_noise_N: \"low\" is not allowed; expected 0 to 10");
  EXPECT_EQ(
      refusal("[manipulandum]\nlink_lengths_m = [0.3]"),
      "mine.toml:2: manipulandum.link_lengths_m: [0.3] is not allowed; expected [x, y], each 0.05 to 2");
  EXPECT_EQ(refusal("[simulation]\nsub_steps = 2.5"),
            "mine.toml:2: simulation.sub_steps: 2.5 is not allowed; expected a whole number, 1 to 1000");
  EXPECT_EQ(
      refusal("[simulation]\nseed = -1"),
      "mine.toml:2: simulation.seed: -1 is not allowed; expected a whole number, 0 to 4611686018427387904");
  EXPECT_EQ(refusal("[subject.drift]\nis_on = 1"),
            "mine.toml:2: subject.drift.is_on: 1 is not allowed; expected true or false");
  EXPECT_EQ(refusal("subject = 4"), "mine.toml:1: subject: 4 is not allowed; expected a table [subject]");
  EXPECT_EQ(refusal("[loop]\nrate_Hz = nan"),
            "mine.toml:2: loop.rate_Hz: nan is not allowed; expected 50 to 4000");
}

TEST(Profile, RefusesAnUnknownKeyAtEveryDepthAndNamesTheOnesThatMayBeMeant) {
  EXPECT_EQ(refusal("[grip]\nstifness_N_per_m = 1e5"),
            "mine.toml:2: grip.stifness_N_per_m: unknown key; did you mean stiffness_N_per_m?");
  EXPECT_EQ(
      refusal("[subject.reflex.stiffness_Nm_per_rad]\nwrist = 1.0"),
      "mine.toml:2: subject.reflex.stiffness_Nm_per_rad.wrist: unknown key; expected one of elbow, shoulder, "
      "two_joint");
  EXPECT_EQ(refusal("[robot]"),
            "mine.toml:1: robot: unknown key; expected one of agent, auxiliary, bench, control, grip, "
            "limits, loop, "
            "manipulandum, "
            "sensors, simulation, subject");
}

TEST(Profile, NamesThePlaceOfASyntaxError) {
  EXPECT_EQ(refusal("[grip]\nstiffness_N_per_m = = 3").substr(0, 22), "mine.toml:2: not TOML:");
}

TEST(Profile, RefusesWhatDoesNotFitTogether) {
  EXPECT_EQ(
      refusal("[subject]\nposture_m = [0.0, 0.7]"),
      "mine.toml:2: subject.posture_m: [0, 0.7] is not allowed; expected a distance from 0.03 to 0.65 m, "
      "exclusive");
  EXPECT_EQ(refusal("[manipulandum]\nhome_m = [0.1, 0.35]"),
            "mine.toml:2: manipulandum.home_m: [0.1, 0.35] is not allowed; expected less than "
            "limits.workspace_radius_m = 0.08 from limits.workspace_centre_m = [0.3, 0.35]");
  EXPECT_EQ(
      refusal("[subject.joint_stiffness_Nm_per_rad]\ntwo_joint = -12.0"),
      "mine.toml:1: subject.joint_stiffness_Nm_per_rad: {shoulder = 22, elbow = 17, two_joint = -12} is not "
      "allowed; expected values that make [[s + d, d], [d, e + d]] positive definite");
  EXPECT_EQ(
      refusal("[simulation]\nsub_steps = 1"),
      "mine.toml:2: simulation.sub_steps: 1 is not allowed; expected 2 or more for this grip at 1000 Hz");
}

TEST(Profile, SaysThatAFileIsNotThere) {
  const auto result = load_profile("no/such/profile.toml");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(result.error().message, ::testing::StartsWith("profile no/such/profile.toml"));
}

TEST(Profile, DescribesItsRigAndModelsItsInertia) {
  const Profile profile;
  const RigGeometry rig = rig_geometry(profile);
  EXPECT_TRUE(tonus::validate(rig));
  EXPECT_NEAR(rig.counts_per_unit[0], 8000.0 / (2.0 * std::numbers::pi), 1e-9);
  EXPECT_NEAR(rig.force_calibration(0, 0), 4.45, 1e-12);
  EXPECT_EQ(rig.handle_mass, profile.sensors.handle_mass);
  const control::LoopConfig config = loop_config(profile);
  EXPECT_TRUE(control::validate(config));
  // Rods, rotors, elbow motor 2 kg, tip 0.3 + 0.05 kg: summed by hand.
  EXPECT_NEAR(config.model.inertia.inner, 0.50 + 1.0 * 0.09 / 3 + (2.0 + 0.8 + 0.35) * 0.09, 1e-12);
  EXPECT_NEAR(config.model.inertia.outer, 0.85 + 0.8 * 0.1225 / 3 + 0.35 * 0.1225, 1e-12);
  EXPECT_NEAR(config.model.inertia.coupling, 0.30 * 0.35 * (0.4 + 0.35), 1e-12);
}

}  // namespace
}  // namespace tonus::simulation
