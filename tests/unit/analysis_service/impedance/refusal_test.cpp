#include <algorithm>
#include <gtest/gtest.h>
#include <numbers>

#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/impedance/parameters.hpp"
#include "tests/support/impedance/linear_rig.hpp"

namespace tonus::impedance::test {
namespace {

using testing::Test;

std::vector<Trial> sound_trials(std::uint64_t seed = 1) {
  SimulatedArm arm = typical_subject();
  arm.drift_rms = 0.15;
  arm.tremor_rms = 0.05;
  return simulate(arm, SimulatedRig{}, directions(), seed);
}

/// Force later by a number of samples (earlier where negative), on one axis or both (-1).
void shift_force(std::vector<Trial>& trials, Eigen::Index samples, int only_axis) {
  for (Trial& trial : trials) {
    const Signals force = trial.force;
    for (Eigen::Index k = 0; k < force.rows(); ++k) {
      const Eigen::Index from = std::clamp<Eigen::Index>(k - samples, 0, force.rows() - 1);
      for (int axis = 0; axis < 2; ++axis) {
        if (only_axis < 0 || axis == only_axis) trial.force(k, axis) = force(from, axis);
      }
    }
  }
}

bool has(const Estimate& estimate, Reason reason) {
  return std::ranges::find(estimate.reasons, reason) != estimate.reasons.end();
}

void expect_no_numbers(const Estimate& estimate) {
  EXPECT_EQ(estimate.status, Status::kUndetermined);
  EXPECT_EQ(
      estimate.value.M.size() + estimate.value.B.size() + estimate.value.K.size() + estimate.value.X0.size(),
      0);
  EXPECT_EQ(estimate.std.K.size() + estimate.low.K.size() + estimate.high.K.size(), 0);
  EXPECT_TRUE(estimate.trace.empty());
}

TEST(Refusal, FindsNothingAmissInSoundData) {
  for (const auto& position : published_positions()) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      SimulatedArm arm = typical_subject(position);
      arm.drift_rms = 0.15;
      arm.tremor_rms = 0.05;
      const Estimate e = identify(simulate(arm, SimulatedRig{}, directions(), seed), Options{}).value();
      EXPECT_EQ(e.status, Status::kOk) << position.transpose() << " seed " << seed << ": "
                                       << (e.reasons.empty() ? "" : name_of(e.reasons[0]));
    }
  }
}

/// Damped as Table IV's most damped subject: B = 0.24 s K, several times as much as typical. Such an arm fits
/// as well with its force shifted by 2 M / B, about 30 ms, but with a negative mass.
SimulatedArm strongly_damped(const Eigen::Vector2d& position = {0.0, 0.38}) {
  SimulatedArm arm = typical_subject(position);
  arm.impedance.B = 0.24 * arm.impedance.K;
  arm.drift_rms = 0.15;
  arm.tremor_rms = 0.05;
  return arm;
}

TEST(Refusal, FindsNothingAmissInSoundDataOfAStronglyDampedArm) {
  for (const auto& position : published_positions()) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const auto trials = simulate(strongly_damped(position), SimulatedRig{}, directions(), seed);
      const Estimate e = identify(trials, Options{}).value();
      EXPECT_FALSE(has(e, Reason::kForceShifted))
          << position.transpose() << " seed " << seed << ": " << e.force_lag.transpose();
    }
  }
}

TEST(Refusal, SuspectsAShiftedForceOfAStronglyDampedArm) {
  // Where it is late by 2 M / B, the mass that it seems to have may be all that shows it.
  for (const auto& position : published_positions()) {
    for (const Eigen::Index samples : {6, -6}) {
      for (const int axis : {-1, 0, 1}) {
        auto trials = simulate(strongly_damped(position), SimulatedRig{}, directions(), 2);
        shift_force(trials, samples, axis);
        const Estimate e = identify(trials, Options{}).value();
        EXPECT_EQ(e.status, Status::kSuspect);
        EXPECT_TRUE(has(e, Reason::kForceShifted) || (samples > 0 && has(e, Reason::kNegativeMass)))
            << position.transpose() << ", " << samples << " samples, axis " << axis << ": "
            << e.force_lag.transpose();
      }
    }
  }
}

TEST(Refusal, IsUndeterminedWithoutTrials) {
  const Estimate estimate = identify({}, Options{}).value();
  expect_no_numbers(estimate);
  EXPECT_TRUE(has(estimate, Reason::kTooFewTrials));
}

TEST(Refusal, IsUndeterminedWithOneTrial) {
  const auto trials = sound_trials();
  const Estimate estimate = identify(std::span(trials).first(1), Options{}).value();
  expect_no_numbers(estimate);
}

TEST(Refusal, IsUndeterminedWithASingleDirectionOfPerturbation) {
  SimulatedArm arm = typical_subject();
  arm.drift_rms = 0.15;
  arm.tremor_rms = 0.05;
  for (const double direction : {0.0, 0.8}) {
    std::vector<double> one_line;
    for (int i = 0; i < 16; ++i) one_line.push_back(direction + (i % 2) * std::numbers::pi);
    const Estimate estimate = identify(simulate(arm, SimulatedRig{}, one_line, 1), Options{}).value();
    expect_no_numbers(estimate);
    EXPECT_EQ(estimate.reasons, std::vector{Reason::kSingleDirection});
  }
}

TEST(Refusal, IsDeterminedWithTwoDirections) {
  std::vector<double> two;
  for (int i = 0; i < 16; ++i) two.push_back((i % 2) * 0.5 * std::numbers::pi);
  EXPECT_EQ(identify(simulate(typical_subject(), SimulatedRig{}, two, 1), Options{})->status, Status::kOk);
}

TEST(Refusal, IsUndeterminedWhereNothingMoves) {
  auto trials = sound_trials();
  for (Trial& trial : trials) trial.displacement.setZero();
  const Estimate estimate = identify(trials, Options{}).value();
  expect_no_numbers(estimate);
}

TEST(Refusal, SuspectsCollinearForceChannels) {
  auto trials = sound_trials();
  for (Trial& trial : trials) trial.force.col(1) = -0.7 * trial.force.col(0);
  Estimate estimate = identify(trials, Options{}).value();
  EXPECT_EQ(estimate.status, Status::kSuspect);
  EXPECT_TRUE(has(estimate, Reason::kCollinearForce));

  // The same with noise of its own on each channel.
  const auto noise = simulate(SimulatedArm{}, SimulatedRig{}, directions(), 9);
  for (std::size_t i = 0; i < trials.size(); ++i) trials[i].force += noise[i].force;
  estimate = identify(trials, Options{}).value();
  EXPECT_EQ(estimate.status, Status::kSuspect);
  EXPECT_TRUE(has(estimate, Reason::kCollinearForce));
}

TEST(Refusal, SuspectsAForceThatIsThirtyMillisecondsLateOrEarly) {
  for (const Eigen::Index samples : {6, -6}) {
    for (const int axis : {-1, 0, 1}) {
      auto trials = sound_trials(2);
      shift_force(trials, samples, axis);
      for (const Method method : kMethods) {
        Options options;
        options.method = method;
        const Estimate estimate = identify(trials, options).value();
        EXPECT_EQ(estimate.status, Status::kSuspect);
        EXPECT_TRUE(has(estimate, Reason::kForceShifted)) << samples << " samples, axis " << axis;
        const int shifted = axis < 0 ? 0 : axis;
        EXPECT_NEAR(estimate.force_lag[shifted], 0.005 * static_cast<double>(samples), 0.0101);
      }
    }
  }
}

TEST(Refusal, TellsAShiftedForceAtAnySampleRate) {
  for (const double sample_rate : {200.0, 1000.0, 4000.0}) {
    SimulatedRig rig;
    rig.sample_period = 1.0 / sample_rate;
    auto trials = simulate(typical_subject(), rig, directions(), 3);
    EXPECT_FALSE(has(identify(trials, Options{}).value(), Reason::kForceShifted)) << sample_rate << " Hz";
    shift_force(trials, static_cast<Eigen::Index>(0.030 * sample_rate), 1);
    const Estimate shifted = identify(trials, Options{}).value();
    EXPECT_TRUE(has(shifted, Reason::kForceShifted)) << sample_rate << " Hz";
    EXPECT_NEAR(shifted.force_lag[1], 0.030, 0.0101) << sample_rate << " Hz";
  }
}

TEST(Refusal, SuspectsAxesOfForceThatAreTurnedAgainstThoseOfMotion) {
  auto trials = sound_trials();
  for (Trial& trial : trials) {
    const Signals force = trial.force;
    trial.force.col(0) = 0.92 * force.col(0) - 0.39 * force.col(1);
    trial.force.col(1) = 0.39 * force.col(0) + 0.92 * force.col(1);
  }
  EXPECT_TRUE(has(identify(trials, Options{}).value(), Reason::kAsymmetricMass));
  EXPECT_FALSE(has(identify(sound_trials(), Options{}).value(), Reason::kAsymmetricMass));
}

TEST(Refusal, SuspectsAClippedSensor) {
  // Clipped as recorded along the channels of the record (fx, fy) at 60 % of the largest force.
  auto trials = sound_trials();
  double largest = 0.0;
  for (const Trial& trial : trials) largest = std::max(largest, trial.force.col(1).cwiseAbs().maxCoeff());
  for (Trial& trial : trials) {
    trial.force.col(1) = trial.force.col(1).cwiseMin(0.6 * largest).cwiseMax(-0.6 * largest);
  }
  const Estimate estimate = identify(trials, Options{}).value();
  EXPECT_EQ(estimate.status, Status::kSuspect);
  EXPECT_EQ(estimate.reasons, std::vector{Reason::kClippedForce});
}

TEST(Refusal, SuspectsATrialMarkedAsClippedWhenItWasConverted) {
  auto trials = sound_trials();
  trials[3].is_clipped = true;
  EXPECT_TRUE(has(identify(trials, Options{}).value(), Reason::kClippedForce));
}

TEST(Refusal, SuspectsANegativeStiffnessHoweverWellItFits) {
  // Closed-loop artefact: the arm moves the passive rig, so that the force is the rig's resistance to it and
  // the fit finds the rig's impedance with the sign turned.
  auto trials = simulate(typical_subject(), ideal_rig(), directions(), 1);
  for (Trial& trial : trials) trial.force = -trial.force;
  const Estimate estimate = identify(trials, Options{}).value();
  EXPECT_GT(estimate.explained.minCoeff(), 0.999);
  EXPECT_EQ(estimate.status, Status::kSuspect);
  EXPECT_TRUE(has(estimate, Reason::kForceSign));
}

TEST(Refusal, HasANameForEveryReason) {
  std::vector<std::string_view> names;
  for (int i = 0; i <= static_cast<int>(Reason::kAtBound); ++i)
    names.push_back(name_of(static_cast<Reason>(i)));
  std::ranges::sort(names);
  EXPECT_EQ(std::ranges::adjacent_find(names), names.end());
  EXPECT_EQ(std::ranges::find(names, "unknown"), names.end());
}

}  // namespace
}  // namespace tonus::impedance::test
