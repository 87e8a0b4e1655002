// The processing against the simulated subject, of whom the true activation is known.

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <numeric>
#include <string>

#include "analysis_service/muscles/trial_activity.hpp"
#include "tests/support/simulated_rig.hpp"

namespace tonus::muscles {
namespace {

constexpr double kRate = 2000.0;
constexpr std::size_t kValues = 2;  // of each channel with a sample of 1 kHz

simulation::Profile with_muscles(std::uint64_t seed) {
  simulation::Profile profile;
  profile.seed = seed;
  profile.sample_divider = 1;
  profile.subject.reflex.is_on = true;
  for (const auto& name : simulation::kMuscleNames)
    profile.auxiliary.push_back({std::string(name), "EMG", "mV", 1.0, kRate});
  return profile;
}

/// What a trial gave, sample by sample.
struct Taken {
  control::TrialResult result;
  std::vector<AuxiliarySeries> series;
  std::vector<simulation::Activations> truth;
  std::size_t onset = 0;  ///< Sample.
};

class SimulatedMuscles {
 public:
  explicit SimulatedMuscles(std::uint64_t seed) : profile_(with_muscles(seed)), rig_(profile_) {}

  control::TrialProgram program(double direction) {
    auto program = rig_.program({0.0, 0.38}, direction);
    program.number = ++number_;
    program.hold = 1.0;
    return program;
  }

  Taken run(const control::TrialProgram& program) {
    Taken run;
    std::vector<std::vector<float>> rows;
    std::vector<float> row(rig_.loop().auxiliary_values());
    control::SampleRecord sample;
    std::uint64_t first = 0;
    rig_.start(program);
    for (int i = 0; i < 30'000 && !rig_.loop().next_result(run.result); ++i) {
      rig_.loop().keep_alive();
      rig_.loop().step(now_ns_ += 1'000'000);
      while (rig_.loop().next_sample(sample, row)) {
        if (sample.trial != program.number) continue;
        if (rows.empty()) first = sample.sequence;
        rows.push_back(row);
        run.truth.push_back(rig_.driver().plant().activation());
      }
    }
    EXPECT_EQ(run.result.outcome, control::TrialOutcome::kCompleted);
    run.onset = run.result.onset_sequence - first;
    run.series = empty_series(profile_.auxiliary, profile_.loop_rate, rows.size());
    for (std::size_t n = 0; n < rows.size(); ++n) put_values(rows[n], n, run.series);
    return run;
  }

  Taken contraction() {
    auto trial = program(0.0);
    trial.kind = control::TrialKind::kContraction;
    trial.amplitude = 0.0;
    trial.hold = 2.0;
    return run(trial);
  }

 private:
  const simulation::Profile profile_;
  SimulatedRig rig_;
  std::uint64_t number_ = 0;
  std::int64_t now_ns_ = 0;
};

/// Trials of one direction together.
struct Pooled {
  std::array<std::vector<double>, simulation::kMuscles>
      squares;  ///< Of the EMG, from kBefore s before the onset.
  std::array<std::vector<double>, simulation::kMuscles> power;  ///< Of the true activation, from the onset.
};
constexpr std::size_t kBefore = 300;  // samples
constexpr std::size_t kAfter = 150;
constexpr std::size_t kTrials = 16;

Pooled pooled(SimulatedMuscles& subject, double direction_deg) {
  Pooled all;
  all.squares.fill(std::vector<double>(kValues * (kBefore + kAfter), 0.0));
  all.power.fill(std::vector<double>(kAfter, 0.0));
  for (std::size_t trial = 0; trial < kTrials; ++trial) {
    const Taken run = subject.run(subject.program(direction_deg * std::numbers::pi / 180.0));
    for (std::size_t muscle = 0; muscle < simulation::kMuscles; ++muscle) {
      const auto rectified = rectified_emg(run.series[muscle].values, kRate).value();
      // The last value of a sample belongs to its instant.
      const std::size_t begin = kValues * (run.onset - kBefore) + kValues - 1;
      for (std::size_t k = 0; k < all.squares[muscle].size(); ++k)
        all.squares[muscle][k] += std::pow(rectified[begin + k], 2.0);
      for (std::size_t n = 0; n < kAfter; ++n)
        all.power[muscle][n] += std::pow(run.truth[run.onset + n][muscle], 2.0) / kTrials;
    }
  }
  return all;
}

/// Seconds after the onset at which the true activation, over all trials, has risen by half; NaN: never.
double true_latency(const std::vector<double>& power) {
  const double rest = std::sqrt(power.front());
  for (std::size_t n = 0; n < power.size(); ++n)
    if (std::sqrt(power[n]) > 1.5 * rest) return static_cast<double>(n) / 1000.0;
  return std::nan("");
}

TEST(SimulatedMuscles, ShowTheLatencyOfEveryReflexWithinTwoMilliseconds) {
  int responses = 0;
  for (int direction = 0; direction < 360; direction += 45) {
    SimulatedMuscles subject(static_cast<std::uint64_t>(direction) + 1);
    const Pooled trials = pooled(subject, direction);
    for (std::size_t muscle = 0; muscle < simulation::kMuscles; ++muscle) {
      const double truth = true_latency(trials.power[muscle]);
      const double found = response_latency(trials.squares[muscle], kTrials, kValues * kBefore, kRate);
      const std::string which =
          std::string(simulation::kMuscleNames[muscle]) + ", " + std::to_string(direction) + " deg";
      if (std::isnan(truth)) {  // shortened by this push
        EXPECT_TRUE(std::isnan(found)) << which << " " << found;
        continue;
      }
      ++responses;
      EXPECT_NEAR(found, truth, 0.002) << which;
      EXPECT_NEAR(truth, 0.045, 0.010) << which;  // the profile's delay, and until the stretch is felt
    }
  }
  EXPECT_EQ(responses, 24);  // three pairs, of which each push stretches one side
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const auto mean = [](const std::vector<double>& v) {
    return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
  };
  double both = 0.0;
  double first = 0.0;
  double second = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double x = a[i] - mean(a);
    const double y = b[i] - mean(b);
    both += x * y;
    first += x * x;
    second += y * y;
  }
  return both / std::sqrt(first * second);
}

class CoContraction : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, CoContraction, ::testing::Range<std::uint64_t>(1, 11));

TEST_P(CoContraction, FollowsTheTrueActivationOfTheSubject) {
  SimulatedMuscles subject(GetParam());
  Reference reference;
  reference.add(id_of("contraction"), subject.contraction().series);
  const MuscleSettings settings{1.0, {{"ShoulderFlexor", "ShoulderExtensor"}}};
  std::vector<double> measured;
  std::vector<double> truth;
  for (int i = 0; i < 16; ++i) {
    auto program = subject.program(0.0);
    const double load = 0.5 * i;
    program.bias = {load * std::cos(0.7 * i), load * std::sin(0.7 * i)};
    program.bias_hold = 0.5;
    const Taken run = subject.run(program);
    const double onset = static_cast<double>(run.onset) / 1000.0;
    const auto activity = reference.measure(run.series, {onset - 0.5, onset}, onset, settings);
    double common = 0.0;
    double sum = 0.0;
    for (std::size_t n = run.onset - 500; n < run.onset; ++n) {
      common += std::min(run.truth[n][0], run.truth[n][1]);
      sum += run.truth[n][0] + run.truth[n][1];
    }
    measured.push_back(activity.co_contraction);
    truth.push_back(2.0 * common / sum);
  }
  const auto [least, most] = std::ranges::minmax(truth);
  EXPECT_GT(most - least, 0.3) << "the loads make a difference";
  EXPECT_GE(correlation(measured, truth), 0.95);
}

}  // namespace
}  // namespace tonus::muscles
