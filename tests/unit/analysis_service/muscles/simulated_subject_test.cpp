// The processing against the simulated subject, of whom the true activation is known.

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

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

/// Seconds after the onset at which the muscle's true activation leaves that of the rest. NaN where it does
/// so slowly, by less than 0.05 in 5 ms: such a response is found late (README).
double true_latency(const Taken& run, std::size_t muscle) {
  const double rest = run.truth[run.onset][muscle];
  for (std::size_t n = run.onset; n + 5 < run.truth.size(); ++n) {
    if (run.truth[n][muscle] <= rest + 0.01) continue;
    const bool is_sudden = run.truth[n + 5][muscle] > rest + 0.05;
    return is_sudden ? static_cast<double>(n - run.onset) / 1000.0 : std::nan("");
  }
  return std::nan("");
}

TEST(SimulatedMuscles, ShowTheLatencyOfTheirReflexWithinTwoMilliseconds) {
  constexpr std::size_t kBefore = 300;  // samples
  constexpr std::size_t kAfter = 150;
  constexpr std::size_t kTrials = 16;
  int responses = 0;
  for (const double direction : {0.0, 90.0, 180.0, 270.0}) {
    SimulatedMuscles subject(static_cast<std::uint64_t>(direction) + 1);
    std::array<std::vector<double>, simulation::kMuscles> squares;
    squares.fill(std::vector<double>(kValues * (kBefore + kAfter), 0.0));
    Taken last;
    for (std::size_t trial = 0; trial < kTrials; ++trial) {
      last = subject.run(subject.program(direction * std::numbers::pi / 180.0));
      for (std::size_t muscle = 0; muscle < simulation::kMuscles; ++muscle) {
        const auto rectified = rectified_emg(last.series[muscle].values, kRate).value();
        // The last value of a sample belongs to its instant.
        const std::size_t begin = kValues * (last.onset - kBefore) + kValues - 1;
        for (std::size_t k = 0; k < squares[muscle].size(); ++k)
          squares[muscle][k] += std::pow(rectified[begin + k], 2.0);
      }
    }
    for (std::size_t muscle = 0; muscle < simulation::kMuscles; ++muscle) {
      const double truth = true_latency(last, muscle);
      if (!(truth < 0.08)) continue;  // shortened by this push, or stretched late
      ++responses;
      EXPECT_NEAR(response_latency(squares[muscle], kTrials, kValues * kBefore, kRate), truth, 0.002)
          << simulation::kMuscleNames[muscle] << ", " << direction << " deg";
      EXPECT_NEAR(truth, 0.040, 0.015);  // the profile's delay, and the time until the stretch is felt
    }
  }
  EXPECT_GE(responses, 8);  // three pairs, of which each push stretches one side
}

TEST(SimulatedMuscles, CoContractAsTheirTrueActivationSays) {
  SimulatedMuscles subject(7);
  Reference reference;
  reference.add(subject.contraction().series);
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
  const auto mean = [](const std::vector<double>& v) {
    double sum = 0.0;
    for (const double value : v) sum += value;
    return sum / static_cast<double>(v.size());
  };
  double both = 0.0;
  double first = 0.0;
  double second = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double a = measured[i] - mean(measured);
    const double b = truth[i] - mean(truth);
    both += a * b;
    first += a * a;
    second += b * b;
  }
  EXPECT_GT(second, 0.1) << "the loads make a difference";
  EXPECT_GE(both / std::sqrt(first * second), 0.95);
}

}  // namespace
}  // namespace tonus::muscles
