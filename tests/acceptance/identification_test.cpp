// What identification promises, on the simulated rig with the published sensors: raw counts and volts of the
// plant, recorded as a dataset, through the services' own conversion.
#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <numbers>

#include "analysis_service/impedance/joint_space.hpp"
#include "analysis_service/offline/offline.hpp"
#include "services/simulation/true_impedance.hpp"
#include "tests/support/simulated_study/simulated_study.hpp"

namespace tonus {
namespace {

using identification::OfflineEstimate;
using impedance::Method;
using impedance::Model;
using simulated::Posture;
using simulated::published_postures;

recording::Recording measured(const simulation::Profile& profile, const Posture& posture,
                              const simulated::Procedure& procedure = {}) {
  auto record = simulated::measure(profile, posture, procedure);
  EXPECT_TRUE(record) << record.error().message;
  return std::move(record).value();
}

v1::Estimate identified(const recording::Recording& record, Method method = Method::kStateVariable,
                        Model model = Model::kLinear) {
  impedance::Options options;
  options.method = method;
  options.model = model;
  const auto estimates = identification::identify_recordings({&record, 1}, {options});
  EXPECT_TRUE(estimates);
  return estimates.value().at(0).estimate;
}

simulation::Profile with_seed(std::uint64_t seed) {
  simulation::Profile profile;
  profile.seed = seed;
  return profile;
}

/// Drift of 0.15 N and tremor of 0.05 N rms on each axis.
simulation::Profile living(std::uint64_t seed) {
  simulation::Profile profile = with_seed(seed);
  profile.subject.drift.is_on = true;
  profile.subject.drift.force = 0.15;
  profile.subject.tremor.is_on = true;
  profile.subject.tremor.force = 0.05;
  return profile;
}

Eigen::Matrix2d matrix_of(const v1::MatrixEstimate& estimate) {
  const auto& v = estimate.value();
  return (Eigen::Matrix2d() << v[0], v[1], v[2], v[3]).finished();
}

/// Largest difference of an element, as a share of the largest element of `b`.
double difference(const Eigen::Matrix2d& a, const Eigen::Matrix2d& b) {
  return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

// Of sound conditions the methods' check refuses fewer than one in a hundred, by its limit: here one of 20,
// whose K(2,2) is 1.8 half-widths of its interval from the truth.
TEST(StateVariable, IsWithinFourPercentOfTheLargestElementAtEveryPosture) {
  int refused = 0;
  for (const Posture& posture : published_postures()) {
    const auto truth = simulation::true_impedance(simulation::SubjectProfile{}, posture.position);
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      SCOPED_TRACE(posture.name + ", seed " + std::to_string(seed));
      const auto estimate = identified(measured(with_seed(seed), posture));
      refused += estimate.status() == v1::ESTIMATE_OK ? 0 : 1;
      for (const std::string& reason : estimate.reasons())
        EXPECT_THAT(reason, testing::StartsWith("methods_differ"));
      EXPECT_LT(difference(matrix_of(estimate.mass_kg()), truth.mass), 0.04);
      EXPECT_LT(difference(matrix_of(estimate.damping_Ns_per_m()), truth.damping), 0.04);
      EXPECT_LT(difference(matrix_of(estimate.stiffness_N_per_m()), truth.stiffness), 0.04);
    }
  }
  EXPECT_LE(refused, 1);
}

TEST(StateVariable, SettlesWithinHalfASecondToEightPercent) {
  for (const Posture& posture : published_postures()) {
    const auto estimate = identified(measured(with_seed(5), posture));
    EXPECT_GE(estimate.settled_s(), 0.0) << posture.name;
    EXPECT_LE(estimate.settled_s(), 0.5) << posture.name;
  }
}

TEST(PublishedMethods, AgreeAsPublished) {
  // tables.toml, patterns.methods_agree_pct: all 15, proximal mass 25, damping 15, stiffness 10; of the
  // largest element.
  for (const Posture& posture : published_postures()) {
    const auto record = measured(with_seed(6), posture);
    std::vector<v1::Estimate> found;
    for (const Method method : impedance::kMethods) found.push_back(identified(record, method));
    const double mass_share = posture.name == "proximal" ? 0.25 : 0.15;
    for (const auto& a : found) {
      for (const auto& b : found) {
        SCOPED_TRACE(posture.name + ": " + a.method() + " and " + b.method());
        EXPECT_LT(difference(matrix_of(a.mass_kg()), matrix_of(b.mass_kg())), mass_share);
        EXPECT_LT(difference(matrix_of(a.damping_Ns_per_m()), matrix_of(b.damping_Ns_per_m())), 0.15);
        EXPECT_LT(difference(matrix_of(a.stiffness_N_per_m()), matrix_of(b.stiffness_N_per_m())), 0.10);
      }
    }
  }
}

TEST(ModelComparison, OrdersTheModelsAsTableTwoDoesUnderDriftAndTremor) {
  const double sensor_noise = simulation::SensorProfile{}.force_noise;
  for (const Posture& posture : published_postures()) {
    const auto record = measured(living(7), posture);
    const auto sigma = [&](Model model) {
      return identified(record, Method::kStateVariable, model).sigma_N();
    };
    const auto linear = sigma(Model::kLinear);
    const auto no_damping = sigma(Model::kNoDamping);
    const auto coriolis = sigma(Model::kCoriolis);
    const auto squared = sigma(Model::kSquaredVelocity);
    const auto signed_squares = sigma(Model::kSignedSquaredVelocity);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      SCOPED_TRACE(posture.name + ", axis " + std::to_string(axis));
      EXPECT_GT(no_damping[axis], linear[axis]);
      EXPECT_LT(no_damping[axis] - coriolis[axis], 0.005);  // N
      EXPECT_LT(linear[axis] - squared[axis], sensor_noise);
      EXPECT_LT(linear[axis] - signed_squares[axis], sensor_noise);
      // Published: comparable with (3). Only squares that keep their sign can be.
      EXPECT_LT(signed_squares[axis] - linear[axis], no_damping[axis] - signed_squares[axis]);
    }
  }
}

TEST(ModelComparison, SeesCoriolisForcesWithoutJointDampingAtTenTimesTheSpeed) {
  // Ten times the displacement in the same time. The arm's inertia changes along so long a way, which none of
  // the models has and which is as large; so the comparison is of (14) with (13), and with (3), whose
  // velocity term finds nothing. A filter of damping ratio 0.7 forgets the large onset within the window.
  // Table II's case, above, allows (14) to be better by 0.005 N.
  simulation::Profile profile = with_seed(8);
  profile.subject.damping = {0.0, 0.0, 0.0};
  profile.sensors.force_full_scale = 100.0;
  profile.limits.workspace_radius = 0.25;
  profile.limits.speed = 1.5;
  profile.limits.force = 99.0;
  profile.limits.encoder_jump = 0.1;
  profile.limits.torque = {100.0, 100.0};
  profile.manipulandum.torque_limits = {100.0, 100.0};
  simulated::Procedure procedure;
  procedure.amplitude = 0.05;
  const auto record = measured(profile, published_postures()[0], procedure);
  const auto sigma = [&](Model model) {
    impedance::Options options;
    options.model = model;
    options.damping_ratio = 0.7;
    identification::JudgeChoice judge;
    judge.is_reaching = true;  // the way is longer than the published protocol's limit
    const auto estimate =
        identification::identify_recordings({&record, 1}, {options}, judge).value().at(0).estimate;
    EXPECT_EQ(estimate.trials_used(), 16U);
    return estimate.sigma_N();
  };
  const auto linear = sigma(Model::kLinear);
  const auto no_damping = sigma(Model::kNoDamping);
  const auto coriolis = sigma(Model::kCoriolis);
  EXPECT_GT(no_damping[0] - coriolis[0], 0.03);  // N
  EXPECT_GT(no_damping[1] - coriolis[1], 0.2);
  EXPECT_LT(coriolis[1], 0.75 * no_damping[1]);
  for (std::size_t axis = 0; axis < 2; ++axis) EXPECT_LT(no_damping[axis] - linear[axis], 0.01);
}

/// Table III: one standard deviation of tau (s) and zeta of each subject, the published spread of such
/// constants.
constexpr double kSpread[simulated::kCohort][2] = {{0.007, 0.02}, {0.005, 0.01}, {0.005, 0.02}, {0.007, 0.02},
                                                   {0.013, 0.03}, {0.030, 0.07}, {0.007, 0.03}, {0.006, 0.04},
                                                   {0.008, 0.02}, {0.006, 0.02}, {0.002, 0.01}};

/// The fit of a hypothesis to what is identified of a subject at the five postures; `damping` gives the joint
/// damping (elements 11, 22, 12) at a posture's inertia and stiffness.
template <typename Damping>
impedance::HypothesisFit fit_of(std::size_t index, impedance::Hypothesis hypothesis, const Damping& damping) {
  std::vector<impedance::PostureImpedance> postures;
  simulation::Profile profile = with_seed(100 + index);
  profile.subject = simulated::cohort_subject(index);
  const TwoLink links = profile.subject.links;
  for (const Posture& posture : published_postures()) {
    const Eigen::Vector2d angles = links.angles_at(posture.position);
    const Eigen::Matrix2d I = impedance::to_joints(
        simulation::true_impedance(profile.subject, posture.position).mass, links.jacobian(angles));
    profile.subject.damping = simulated::joint_impedance_of(damping(I, profile.subject.stiffness.matrix()));
    const auto found = identified(measured(profile, posture));
    // Of the most damped subject the method's K leaves its interval at two postures, and the methods' check
    // says so.
    for (const std::string& reason : found.reasons())
      EXPECT_THAT(reason, testing::StartsWith("methods_differ")) << posture.name;
    postures.push_back({posture.position,
                        {matrix_of(found.mass_kg()), matrix_of(found.damping_Ns_per_m()),
                         matrix_of(found.stiffness_N_per_m())}});
  }
  return impedance::fit_hypothesis(impedance::joint_matrices(postures, links).value(), hypothesis).value();
}

Eigen::Vector3d elements_of(const Eigen::Matrix2d& matrix) {
  return {matrix(0, 0), matrix(1, 1), matrix(0, 1)};
}

class EverySubject : public testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(TableFour, EverySubject, testing::Range<std::size_t>(0, simulated::kCohort));

TEST_P(EverySubject, GivesTheScalingConstantsBackWithinThePublishedSpread) {
  const auto& row = simulated::table_four()[GetParam()];
  const auto fit = fit_of(GetParam(), impedance::Hypothesis::kMS,
                          [&](const Eigen::Matrix2d&, const Eigen::Matrix2d& K) -> Eigen::Vector3d {
                            return row.tau.cwiseProduct(elements_of(K));
                          });
  EXPECT_LT((fit.constants - row.tau).cwiseAbs().maxCoeff(), kSpread[GetParam()][0])
      << fit.constants.transpose();
  EXPECT_LT(fit.error, row.ms_error);
}

TEST_P(EverySubject, GivesTheDampingRatiosBackWithinThePublishedSpread) {
  const auto& row = simulated::table_four()[GetParam()];
  const auto fit = fit_of(GetParam(), impedance::Hypothesis::kMD,
                          [&](const Eigen::Matrix2d& I, const Eigen::Matrix2d& K) -> Eigen::Vector3d {
                            const Eigen::Array3d product = elements_of(I).cwiseProduct(elements_of(K));
                            return 2.0 * row.zeta.array() * product.max(0.0).sqrt();
                          });
  EXPECT_LT((fit.constants - row.zeta).cwiseAbs().maxCoeff(), kSpread[GetParam()][1])
      << fit.constants.transpose();
  EXPECT_LT(fit.error, row.md_error);
}

}  // namespace
}  // namespace tonus
