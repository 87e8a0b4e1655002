#include "analysis_service/muscles/trial_activity.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

namespace tonus::muscles {
namespace {

constexpr double kRate = 2000.0;
constexpr double kOnset = 1.0;  // s
constexpr Window kRest{0.5, 1.0};

/// 150 Hz, which the band lets through, with an effective value that follows the time, s. The mean of its
/// magnitude is 2 sqrt(2) / pi of that.
template <typename Effective>
AuxiliarySeries emg(const std::string& name, const Effective& effective, double duration = 2.0) {
  AuxiliarySeries series{{name, "EMG", "V", 1.0, kRate}, 10, {}};  // with samples at 200 Hz
  for (std::size_t k = 0; k < static_cast<std::size_t>(duration * kRate); ++k) {
    const double t = series.time_of(k);
    const double wave = std::numbers::sqrt2 * std::sin(2.0 * std::numbers::pi * 150.0 * t);
    series.values.push_back(static_cast<float>(effective(t) * wave));
  }
  return series;
}

std::vector<AuxiliarySeries> contraction() {
  const auto full = [](double) { return 1.0; };
  return {emg("biceps", full), emg("triceps", full)};
}

TEST(TrialActivity, IsRelativeToTheReferenceContraction) {
  Reference reference;
  reference.add(id_of("contraction"), contraction());
  const auto deviation = [](double t) {
    if (t < kOnset) return 0.05;
    if (t < kOnset + 0.05) return 0.4;
    return t < kOnset + 0.1 ? 0.8 : 0.05;
  };
  const auto found = reference.measure(std::vector{emg("biceps", deviation)}, kRest, kOnset, {});
  ASSERT_EQ(found.muscles.size(), 1U);
  const Activity& biceps = found.muscles[0];
  EXPECT_TRUE(biceps.is_normalised);
  EXPECT_NEAR(biceps.before_onset, 0.05, 0.002);
  EXPECT_NEAR(biceps.short_latency, 0.4, 0.03);
  EXPECT_NEAR(biceps.long_latency, 0.8, 0.05);
}

TEST(TrialActivity, RefersToTheStrongestContractionThatStillCounts) {
  Reference reference;
  reference.add(id_of("weak"), std::vector{emg("biceps", [](double) { return 0.5; })});
  reference.add(id_of("strong"), std::vector{emg("biceps", [](double) { return 2.0; })});
  const double strong = reference.level("biceps");
  reference.withdraw(id_of("strong"));
  EXPECT_NEAR(reference.level("biceps"), strong / 4.0, 0.01 * strong);
  reference.withdraw(id_of("nobody's"));
  EXPECT_TRUE(std::isfinite(reference.level("biceps")));
  reference.withdraw(id_of("weak"));
  EXPECT_TRUE(std::isnan(reference.level("biceps")));
}

TEST(TrialActivity, IsInTheChannelsUnitWithoutAReference) {
  const Reference reference;
  const auto found =
      reference.measure(std::vector{emg("biceps", [](double) { return 2.0; })}, kRest, kOnset, {0.1, {}});
  EXPECT_FALSE(found.muscles.at(0).is_normalised);
  EXPECT_NEAR(found.muscles[0].before_onset, 2.0 * 2.0 * std::numbers::sqrt2 / std::numbers::pi, 0.02);
  EXPECT_TRUE(found.above(0.1).empty()) << "nothing is said of it";
}

TEST(TrialActivity, NamesTheMusclesThatWereNotRelaxed) {
  Reference reference;
  reference.add(id_of("contraction"), contraction());
  const auto found = reference.measure(
      std::vector{emg("biceps", [](double) { return 0.3; }), emg("triceps", [](double) { return 0.02; })},
      kRest, kOnset, {});
  const auto active = found.above(0.1);
  ASSERT_EQ(active.size(), 1U);
  EXPECT_EQ(active[0].substr(0, 9), "biceps 0.");
}

TEST(TrialActivity, CoContractionFollowsTheWeakerOfTheAntagonists) {
  Reference reference;
  reference.add(id_of("contraction"), contraction());
  const MuscleSettings settings{0.1, {{"biceps", "triceps"}}};
  const auto index = [&](double first, double second) {
    return reference
        .measure(std::vector{emg("biceps", [=](double) { return first; }),
                             emg("triceps", [=](double) { return second; })},
                 kRest, kOnset, settings)
        .co_contraction;
  };
  EXPECT_GT(index(0.3, 0.3), 0.85);
  EXPECT_NEAR(index(0.3, 0.1), 0.5, 0.02);
  EXPECT_LT(index(0.3, 0.0), 0.01);
  const MuscleSettings unknown{0.1, {{"biceps", "deltoid"}}};
  EXPECT_TRUE(std::isnan(reference.measure(contraction(), kRest, kOnset, unknown).co_contraction));
}

TEST(TrialActivity, OnlyEmgChannelsAreMuscles) {
  auto trigger = emg("trigger", [](double) { return 1.0; });
  trigger.channel.type = "TRIG";
  EXPECT_TRUE(Reference().measure(std::vector{trigger}, kRest, kOnset, {}).muscles.empty());
}

TEST(TrialActivity, IsNotKnownWhereTheValuesAreMissing) {
  auto series = emg("biceps", [](double) { return 1.0; });
  std::fill(series.values.begin(), series.values.end(), std::numeric_limits<float>::quiet_NaN());
  const auto found = Reference().measure(std::vector{series}, kRest, kOnset, {});
  EXPECT_TRUE(std::isnan(found.muscles.at(0).before_onset));
  EXPECT_TRUE(std::isnan(found.muscles[0].short_latency));
}

}  // namespace
}  // namespace tonus::muscles
