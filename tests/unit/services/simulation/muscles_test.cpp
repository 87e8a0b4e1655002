#include "services/simulation/muscles.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "services/simulation/auxiliary_signals.hpp"
#include "services/simulation/plant.hpp"

namespace tonus::simulation {
namespace {

MuscleDemand rest_of(const SubjectProfile& subject) {
  MuscleDemand demand;
  demand.stiffness = subject.stiffness.matrix();
  return demand;
}

TEST(Muscles, ShareATorqueThatAddsUpWithTheLeastStrain) {
  const JointImpedance strength{60.0, 50.0, 25.0};
  const Eigen::Vector2d torque(2.0, -1.0);
  const Eigen::Vector3d t = shared_torque(torque, strength);
  EXPECT_NEAR(t[0] + t[2], 2.0, 1e-12);
  EXPECT_NEAR(t[1] + t[2], -1.0, 1e-12);
  const auto strain = [&](double both) {
    return std::pow((2.0 - both) / 60.0, 2) + std::pow((-1.0 - both) / 50.0, 2) + std::pow(both / 25.0, 2);
  };
  EXPECT_LT(strain(t[2]), strain(t[2] + 0.01));
  EXPECT_LT(strain(t[2]), strain(t[2] - 0.01));
}

TEST(Muscles, AreActiveWithTheStiffnessOfTheirGroup) {
  const SubjectProfile subject;
  MuscleDemand demand = rest_of(subject);
  for (const double a : activations(subject, demand)) EXPECT_DOUBLE_EQ(a, 0.02);
  demand.stiffness *= 2.0;
  for (const double a : activations(subject, demand)) EXPECT_DOUBLE_EQ(a, 0.22);
  demand.stiffness *= 0.35;  // relaxed: 0.7 of the profile's
  for (const double a : activations(subject, demand)) EXPECT_DOUBLE_EQ(a, 0.005);
  demand.stiffness *= 100.0;
  for (const double a : activations(subject, demand)) EXPECT_EQ(a, 1.0);
}

TEST(Muscles, PullAgainstALoadOnOneSideOfThePair) {
  const SubjectProfile subject;
  MuscleDemand demand = rest_of(subject);
  demand.load = {3.0, 0.0};
  const Activations a = activations(subject, demand);
  const Eigen::Vector3d t = shared_torque(demand.load, subject.muscles.strength);
  EXPECT_NEAR(a[0], 0.02 + t[0] / 60.0, 1e-12);
  EXPECT_DOUBLE_EQ(a[1], 0.02);
  EXPECT_NEAR(a[3], 0.02 - t[1] / 50.0, 1e-12);
}

TEST(Muscles, AnswerTheirOwnStretchAlone) {
  const SubjectProfile subject;
  MuscleDemand demand = rest_of(subject);
  demand.felt_rates = {0.103, 0.0};  // flexion of the shoulder stretches its extensor and the two-joint one
  const Activations a = activations(subject, demand);
  const double answer = 0.3 * std::pow(0.1, 0.3);
  EXPECT_NEAR(a[1], 0.02 + answer, 1e-12);
  EXPECT_NEAR(a[5], 0.02 + answer, 1e-12);
  for (const std::size_t other : {0U, 2U, 3U, 4U}) EXPECT_DOUBLE_EQ(a[other], 0.02);
}

/// Mean square of a band of a signal by a one-bin transform each hertz.
double power_between(const std::vector<double>& signal, double rate, double low, double high) {
  double power = 0.0;
  for (double f = low; f < high; f += 1.0) {
    double re = 0.0;
    double im = 0.0;
    for (std::size_t i = 0; i < signal.size(); ++i) {
      const double angle = 2.0 * std::numbers::pi * f * static_cast<double>(i) / rate;
      re += signal[i] * std::cos(angle);
      im += signal[i] * std::sin(angle);
    }
    power += 2.0 * (re * re + im * im) / std::pow(static_cast<double>(signal.size()), 2);
  }
  return power;
}

TEST(Electromyogram, IsNoiseOfTheWantedStrengthBetween20And450Hertz) {
  Electromyogram emg(2000.0, 7, 16);
  std::vector<double> signal;
  double square = 0.0;
  for (int i = 0; i < 2000; ++i) signal.push_back(emg.next(0.5));
  Electromyogram longer(2000.0, 7, 16);
  constexpr int kMany = 200'000;
  for (int i = 0; i < kMany; ++i) square += std::pow(longer.next(0.5), 2);
  EXPECT_NEAR(std::sqrt(square / kMany), 0.5, 0.01);
  const double inside = power_between(signal, 2000.0, 30.0, 400.0);
  EXPECT_GT(inside, 50.0 * power_between(signal, 2000.0, 1.0, 10.0));
  EXPECT_GT(inside, 20.0 * power_between(signal, 2000.0, 800.0, 1000.0));
}

TEST(Electromyogram, IsTheSameForTheSameSeedAndAnotherForAnother) {
  Electromyogram a(2000.0, 7, 16);
  Electromyogram b(2000.0, 7, 16);
  Electromyogram c(2000.0, 8, 16);
  int same = 0;
  for (int i = 0; i < 100; ++i) {
    const double value = a.next(1.0);
    EXPECT_EQ(value, b.next(1.0));
    same += value == c.next(1.0) ? 1 : 0;
  }
  EXPECT_EQ(same, 0);
}

TEST(AuxiliarySignals, RefuseAChannelThatASimulatedRigCannotHave) {
  const auto refusal = [](const AuxiliaryChannel& channel) {
    const auto valid = validate_auxiliary(std::vector<AuxiliaryChannel>{channel});
    return valid ? "accepted" : valid.error().message;
  };
  EXPECT_EQ(refusal({"ElbowFlexor", "EMG", "uV", 0.25, 1000.0}), "accepted");
  EXPECT_EQ(refusal({"Onset", "TRIG", "n/a", 1.0, 200.0}), "accepted");
  EXPECT_EQ(refusal({"Biceps", "EMG", "mV", 1.0, 1000.0}),
            "simulated: auxiliary channel Biceps: name: Biceps is not allowed; expected ShoulderFlexor, "
            "ShoulderExtensor, ElbowFlexor, ElbowExtensor, TwoJointFlexor, TwoJointExtensor, Onset");
  EXPECT_EQ(refusal({"ElbowFlexor", "EMG", "N", 1.0, 1000.0}),
            "simulated: auxiliary channel ElbowFlexor: unit: N is not allowed; expected V, mV or uV");
}

TEST(AuxiliarySignals, AreInTheirUnitTimesTheirScale) {
  MuscleProfile muscles;
  const std::vector<AuxiliaryChannel> channels{{"ElbowFlexor", "EMG", "uV", 0.25, 2000.0}};
  AuxiliarySignals signals(channels, muscles, 3);
  Activations active{};
  active[2] = 0.5;
  std::vector<float> values(100'000);
  const std::vector<std::uint32_t> counts{100'000};
  signals.measure(active, false, counts, values);
  double square = 0.0;
  for (const float v : values) square += std::pow(0.25 * v, 2);
  EXPECT_NEAR(std::sqrt(square / 1e5), std::hypot(500.0, 4.0), 10.0);
}

TEST(Plant, FeelsAStretchInTheMusclesAfterTheReflexesDelay) {
  PlantProfile profile;
  profile.subject.reflex.is_on = true;
  profile.subject.reflex.delay = 0.04;
  profile.auxiliary = {{"ElbowFlexor", "EMG", "mV", 1.0, 2000.0}};
  Plant plant(profile, 0.001);
  const auto hardest = [&] {
    const auto& active = plant.activation();
    return *std::max_element(active.begin(), active.end());
  };
  for (int i = 0; i < 500; ++i) {
    (void)plant.measure();
    plant.step({0.0, 0.0});
  }
  (void)plant.measure();
  ASSERT_LT(hardest(), 0.03);
  int stretched = -1;
  int answered = -1;
  for (int i = 0; i < 200 && answered < 0; ++i) {
    plant.step({8.0, 0.0});
    (void)plant.measure();
    const auto& rates = plant.state().t_rate;
    const double quickest = std::max({std::abs(rates[0]), std::abs(rates[1]), std::abs(rates[0] + rates[1])});
    if (stretched < 0 && quickest > profile.subject.muscles.reflex_threshold) stretched = i;
    if (hardest() > 0.04) answered = i;
  }
  ASSERT_GE(stretched, 0);
  ASSERT_GE(answered, 0);
  EXPECT_NEAR(answered - stretched, 40, 2);
}

TEST(Plant, IsTheSameWithAndWithoutAuxiliaryChannels) {
  PlantProfile profile;
  profile.subject.reflex.is_on = true;
  profile.subject.tremor.is_on = true;
  Plant without(profile, 0.001);
  profile.auxiliary = {{"ElbowFlexor", "EMG", "mV", 1.0, 2000.0}};
  Plant with(profile, 0.001);
  const std::vector<std::uint32_t> counts{2};
  std::vector<float> values(2);
  for (int i = 0; i < 1000; ++i) {
    const RawSample a = without.measure();
    const RawSample b = with.measure();
    with.measure_auxiliary(counts, values);
    ASSERT_EQ(a.force_V, b.force_V);
    ASSERT_EQ(a.encoder_count, b.encoder_count);
    without.step({1.0, 0.5});
    with.step({1.0, 0.5});
  }
}

TEST(Subject, IsNotRelaxedInExactlyTheChosenTrials) {
  PlantProfile profile;
  profile.subject.misconduct.is_on = true;
  profile.subject.misconduct.tenses = {2};
  profile.subject.misconduct.after = 0.1;
  profile.auxiliary = {{"ElbowFlexor", "EMG", "mV", 1.0, 2000.0}};
  Plant plant(profile, 0.001);
  for (int trial = 1; trial <= 3; ++trial) {
    plant.begin_trial();
    for (int i = 0; i < 300; ++i) {
      plant.step({0.0, 0.0});
      (void)plant.measure();
    }
    for (const double a : plant.activation()) EXPECT_NEAR(a, trial == 2 ? 0.17 : 0.02, 0.002) << trial;
  }
}

}  // namespace
}  // namespace tonus::simulation
