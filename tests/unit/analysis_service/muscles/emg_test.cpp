#include "analysis_service/muscles/emg.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <random>

namespace tonus::muscles {
namespace {

constexpr double kRate = 2000.0;
constexpr float kNotMeasured = std::numeric_limits<float>::quiet_NaN();

std::vector<float> sine(double frequency, double amplitude, double offset, double duration) {
  std::vector<float> values;
  for (int k = 0; k < duration * kRate; ++k)
    values.push_back(
        static_cast<float>(offset + amplitude * std::sin(2.0 * std::numbers::pi * frequency * k / kRate)));
  return values;
}

double settled_mean(const std::vector<float>& values) {
  const auto rectified = rectified_emg(values, kRate);
  EXPECT_TRUE(rectified);
  return mean_activity(*rectified, kRate, {1.0, 2.0});
}

// |H|^2 of a second-order Butterworth filter after the bilinear transform, with w = tan(pi f / rate).
double gain(double frequency, double low, double high) {
  const auto w = [](double f) { return std::tan(std::numbers::pi * f / kRate); };
  const double up = 1.0 / std::sqrt(1.0 + std::pow(w(low) / w(frequency), 4.0));
  const double down = 1.0 / std::sqrt(1.0 + std::pow(w(frequency) / w(high), 4.0));
  return up * down;
}

TEST(Emg, ASineComesThroughWithTheGainOfTheBand) {
  for (const double frequency : {5.0, 20.0, 100.0, 450.0, 700.0}) {
    const double expected = gain(frequency, 20.0, 450.0) * 2.0 / std::numbers::pi;
    EXPECT_NEAR(settled_mean(sine(frequency, 1.0, 0.0, 2.0)), expected, 0.006) << frequency << " Hz";
  }
}

TEST(Emg, AnOffsetIsRemoved) {
  EXPECT_NEAR(settled_mean(sine(100.0, 1.0, 50.0, 2.0)), settled_mean(sine(100.0, 1.0, 0.0, 2.0)), 1e-4);
}

TEST(Emg, TheUpperEdgeStaysBelowHalfTheRate) {
  std::vector<float> values(1000);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = k % 4 < 2 ? 1.0F : -1.0F;  // 50 Hz at 200 Hz
  const auto rectified = rectified_emg(values, 200.0);
  ASSERT_TRUE(rectified);
  EXPECT_GT(mean_activity(*rectified, 200.0, {2.0, 4.0}), 0.5);
  const auto refused = rectified_emg(values, 40.0);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "EMG: a rate of 40 Hz is not allowed; expected more than 44.4444 Hz");
}

TEST(Emg, NothingShowsBeforeItHappens) {
  std::vector<float> values(2000, 0.0F);
  std::mt19937 generator(3);
  std::normal_distribution<float> noise(0.0F, 1.0F);
  for (std::size_t k = 0; k < 1000; ++k) values[k] = noise(generator);
  std::vector<float> with_response = values;
  for (std::size_t k = 1000; k < 2000; k += 2) {
    with_response[k] += 100.0F;
    with_response[k + 1] -= 100.0F;
  }
  const auto without = rectified_emg(values, kRate);
  const auto with = rectified_emg(with_response, kRate);
  for (std::size_t k = 0; k < 1000; ++k) ASSERT_NEAR((*without)[k], (*with)[k], 1e-6) << k;
}

TEST(Emg, WhatWasNotMeasuredIsNotKnown) {
  auto values = sine(100.0, 1.0, 0.0, 2.0);
  for (std::size_t k = 2000; k < 3400; ++k) values[k] = kNotMeasured;
  const auto rectified = rectified_emg(values, kRate);
  EXPECT_TRUE(std::isnan((*rectified)[2500]));
  EXPECT_TRUE(std::isnan(mean_activity(*rectified, kRate, {1.0, 2.0}))) << "70 % are missing";
  EXPECT_TRUE(std::isfinite(mean_activity(*rectified, kRate, {0.5, 1.5})));
  EXPECT_TRUE(std::isnan(mean_activity(*rectified, kRate, {1.5, 2.5}))) << "reaches beyond the signal";
}

TEST(Emg, TheEnvelopeHasNoDelay) {
  std::vector<double> rectified;
  for (int k = 0; k < 4000; ++k)
    rectified.push_back(1.0 + 0.5 * std::cos(2.0 * std::numbers::pi * 1.0 * k / kRate));
  const auto envelope = envelope_of(rectified, kRate);
  for (std::size_t k = 1000; k < 3000; ++k) ASSERT_NEAR(envelope[k], rectified[k], 0.001);
}

TEST(Emg, TheReferenceIsTheLargestHalfSecond) {
  std::vector<double> rectified(6000, 1.0);
  for (std::size_t k = 2000; k < 3000; ++k) rectified[k] = 3.0;
  EXPECT_NEAR(reference_level(rectified, kRate), 3.0, 1e-12);
  EXPECT_TRUE(std::isnan(reference_level(std::vector<double>(100, 1.0), kRate)));
}

TEST(Emg, CoContractionIsOneWhereBothActAlikeAndNoneWhereOneActs) {
  const std::vector<double> one(100, 0.2);
  const std::vector<double> half(100, 0.1);
  const std::vector<double> none(100, 0.0);
  EXPECT_DOUBLE_EQ(co_contraction(one, one), 1.0);
  EXPECT_DOUBLE_EQ(co_contraction(one, none), 0.0);
  EXPECT_NEAR(co_contraction(one, half), 2.0 * 0.1 / 0.3, 1e-12);
  EXPECT_TRUE(std::isnan(co_contraction(none, none)));
  EXPECT_TRUE(std::isnan(co_contraction(one, std::vector<double>(99, 0.2))));
}

/// Sums of squares of `trials` noise signals whose deviation rises from 1 to `after` at 0.5 s + `latency`.
std::vector<double> pooled(double latency, double after, std::size_t trials, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> noise;
  std::vector<double> squares(1400, 0.0);
  for (std::size_t trial = 0; trial < trials; ++trial) {
    for (std::size_t k = 0; k < squares.size(); ++k) {
      const double deviation = k < static_cast<std::size_t>((0.5 + latency) * kRate) ? 1.0 : after;
      squares[k] += std::pow(deviation * noise(generator), 2.0);
    }
  }
  return squares;
}

TEST(Emg, FindsTheLatencyOfAResponseWithinTwoMilliseconds) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const double latency = 0.020 + 0.002 * seed;
    EXPECT_NEAR(response_latency(pooled(latency, 2.0, 16, seed), 16, 1000, kRate), latency, 0.002);
  }
}

/// As pooled(), but rising over 12 ms from the latency on.
TEST(Emg, FindsTheBeginOfAResponseThatRisesGradually) {
  constexpr std::size_t kTrials = 16;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const double latency = 0.020 + 0.002 * seed;
    std::mt19937 generator(seed);
    std::normal_distribution<double> noise;
    std::vector<double> squares(1400, 0.0);
    for (std::size_t trial = 0; trial < kTrials; ++trial) {
      for (std::size_t k = 0; k < squares.size(); ++k) {
        const double risen = std::clamp((static_cast<double>(k) / kRate - 0.5 - latency) / 0.012, 0.0, 1.0);
        squares[k] += std::pow((1.0 + 5.0 * risen) * noise(generator), 2.0);
      }
    }
    EXPECT_NEAR(response_latency(squares, kTrials, 1000, kRate), latency, 0.002) << seed;
  }
}

TEST(Emg, FindsNoLatencyWhereNothingChanges) {
  for (unsigned seed = 1; seed <= 20; ++seed)
    EXPECT_TRUE(std::isnan(response_latency(pooled(0.04, 1.0, 16, seed), 16, 1000, kRate))) << seed;
}

}  // namespace
}  // namespace tonus::muscles
