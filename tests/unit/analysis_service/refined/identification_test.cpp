#include "analysis_service/refined/identification.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "tests/support/impedance/linear_rig.hpp"

namespace tonus::refined {
namespace {

namespace lab = impedance::test;

std::vector<Trial> trials_of(const lab::SimulatedArm& arm, const lab::SimulatedRig& rig,
                             const std::vector<double>& directions, std::uint64_t seed) {
  std::vector<Trial> all;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const lab::RawTrial raw = lab::simulate_raw(arm, rig, directions[i], 1000 * seed + i);
    const auto samples = lab::convert_all(rig, raw.samples);
    const auto rows = static_cast<Eigen::Index>(samples.size());
    Trial trial{Eigen::MatrixXd(rows, 2), Eigen::MatrixXd(rows, 2), Eigen::MatrixXd(rows, 2), raw.onset};
    for (Eigen::Index k = 0; k < rows; ++k) {
      const auto at = static_cast<std::size_t>(k);
      trial.displacement.row(k) = samples[at].p_SE.transpose();
      trial.force.row(k) = samples[at].f_S.transpose();
      trial.commanded.row(k) = raw.commanded[at].transpose();
    }
    for (auto* signal : {&trial.displacement, &trial.force}) {
      const Eigen::RowVectorXd rest = signal->topRows(raw.onset).colwise().mean();
      signal->rowwise() -= rest;
      (signal == &trial.force ? trial.force_taken : trial.displacement_taken) = rest.transpose();
    }
    all.push_back(std::move(trial));
  }
  return all;
}

Settings settings_of(const lab::SimulatedRig& rig) { return {rig.sample_period, 1.0, 0.0}; }

Eigen::MatrixXd matrix(const Estimate& estimate, Eigen::Index which) {
  return estimate.theta.middleRows(2 * which, 2).transpose();
}

double worst_error(const Estimate& estimate, const lab::SimulatedArm& arm) {
  return std::max({lab::relative_error(matrix(estimate, 0), arm.impedance.M),
                   lab::relative_error(matrix(estimate, 1), arm.impedance.B),
                   lab::relative_error(matrix(estimate, 2), arm.impedance.K)});
}

TEST(Refined, FindsTheArmExactlyWhereSensorsArePerfect) {
  for (const double rise : {0.05, 0.2}) {
    lab::SimulatedRig rig = lab::ideal_rig();
    rig.rise = rise;
    const auto arm = lab::typical_subject();
    const Estimate found = identify(trials_of(arm, rig, lab::directions(), 1), settings_of(rig));
    ASSERT_EQ(found.shortage, Shortage::kNone);
    EXPECT_LT(worst_error(found, arm), 2e-3) << rise;
    EXPECT_GT(found.misfit.explained.minCoeff(), 0.9999);
  }
}

TEST(Refined, FindsTheSameArmAtOneKilohertz) {
  lab::SimulatedRig rig = lab::ideal_rig();
  rig.rise = 0.1;
  rig.sample_period = 0.001;
  const auto arm = lab::typical_subject();
  EXPECT_LT(worst_error(identify(trials_of(arm, rig, lab::directions(1), 1), settings_of(rig)), arm), 2e-3);
}

TEST(Refined, StaysWithinFivePercentWhereTheArmDriftsAndTrembles) {
  lab::SimulatedRig rig;
  rig.rise = 0.1;
  lab::SimulatedArm arm = lab::typical_subject();
  arm.drift_rms = 0.2;
  arm.tremor_rms = 0.1;
  const Estimate found = identify(trials_of(arm, rig, lab::directions(4), 5), settings_of(rig));
  EXPECT_LT(worst_error(found, arm), 0.05);
}

TEST(Refined, MassIsThatBehindTheHandle) {
  const lab::SimulatedRig rig = lab::ideal_rig();
  const auto arm = lab::typical_subject();
  const auto trials = trials_of(arm, rig, lab::directions(1), 1);
  Settings settings = settings_of(rig);
  const Eigen::MatrixXd with = matrix(identify(trials, settings), 0);
  settings.handle_mass = 0.3;
  const Eigen::MatrixXd without = matrix(identify(trials, settings), 0);
  EXPECT_LT((with - without - 0.3 * Eigen::Matrix2d::Identity()).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Refined, SaysWhichDataAreMissing) {
  const lab::SimulatedRig rig;
  const auto trials = trials_of(lab::typical_subject(), rig, lab::directions(1), 1);
  const auto first = [&](std::size_t count) {
    return std::vector<Trial>(trials.begin(), trials.begin() + static_cast<std::ptrdiff_t>(count));
  };
  EXPECT_EQ(identify(first(3), settings_of(rig)).shortage, Shortage::kTooFewTrials);
  EXPECT_EQ(identify({trials[0], trials[4], trials[0], trials[4]}, settings_of(rig)).shortage,
            Shortage::kSingleDirection);
  auto without = trials;
  without[2].commanded.resize(0, 2);
  EXPECT_EQ(identify(without, settings_of(rig)).shortage, Shortage::kNoCommand);
  auto short_ones = trials;
  for (Trial& trial : short_ones) {
    for (auto* signal : {&trial.displacement, &trial.force, &trial.commanded})
      *signal = signal->middleRows(trial.onset - 10, 30).eval();
    trial.onset = 10;
  }
  EXPECT_EQ(identify(short_ones, settings_of(rig)).shortage, Shortage::kTooFewRows);
}

TEST(Refined, GivesNoWeightToWhereTheHandRestedOrTheSensorsZero) {
  const lab::SimulatedRig rig;
  const auto trials = trials_of(lab::typical_subject(), rig, lab::directions(1), 2);
  auto moved = trials;
  for (Trial& trial : moved) {
    trial.force_taken.array() += 3.0;
    trial.displacement_taken.array() += 0.1;
  }
  EXPECT_LT((identify(trials, settings_of(rig)).theta - identify(moved, settings_of(rig)).theta)
                .cwiseAbs()
                .maxCoeff(),
            1e-9);
}

}  // namespace
}  // namespace tonus::refined
