// Figures of the published perturbations (Dolan, Friedman and Nagurka 1993, "Experimental procedures"): 5 mm
// commanded, excursions up to 10 mm, rise time 0.2 s, underdamped, accelerations of about 1.5 m/s2,
// negligible force before. 0.2 s is read as the time from the onset to the first peak: with 5 mm and 1.5 m/s2
// no other reading is possible.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <iterator>
#include <numbers>
#include <numeric>
#include <vector>

#include "services/mechanics/rig_geometry.hpp"
#include "tests/support/simulated_rig.hpp"

namespace tonus::control {
namespace {

struct Trace {
  std::vector<Eigen::Vector2d> displacement;  // m in S, from the onset on, one a sample.
  std::vector<Eigen::Vector2d> force_before;  // N in S, the last 0.5 s before the onset.
};

Trace trace(SimulatedRig& rig, const TrialProgram& program) {
  const std::size_t begin = rig.samples().size();
  const TrialResult result = rig.run(program);
  EXPECT_EQ(result.outcome, TrialOutcome::kCompleted);
  Trace t;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  for (std::size_t i = begin; i < rig.samples().size(); ++i) {
    const SampleRecord& sample = rig.samples()[i];
    const EndpointSample endpoint = convert(rig.driver().geometry(), program.shoulder, sample.raw);
    if (sample.sequence == result.onset_sequence) origin = endpoint.p_SE;
    if (sample.phase == Phase::kPerturbing) t.displacement.push_back(endpoint.p_SE - origin);
    if (sample.phase == Phase::kWaiting) t.force_before.push_back(endpoint.f_S);
  }
  return t;
}

double largest_norm(const std::vector<Eigen::Vector2d>& v) {
  return std::transform_reduce(
      v.begin(), v.end(), 0.0, [](double a, double b) { return std::max(a, b); },
      [](const Eigen::Vector2d& x) { return x.norm(); });
}

// Central second difference over 5 ms each side at 1 kHz.
double largest_acceleration(const std::vector<Eigen::Vector2d>& x) {
  double largest = 0.0;
  for (std::size_t i = 5; i + 5 < x.size(); ++i) {
    largest = std::max(largest, (x[i + 5] - 2.0 * x[i] + x[i - 5]).norm() / (0.005 * 0.005));
  }
  return largest;
}

double time_of_first_peak(const std::vector<Eigen::Vector2d>& x, const Eigen::Vector2d& direction) {
  std::size_t peak = 0;
  for (std::size_t i = 0; i < 300 && i < x.size(); ++i) {
    if (x[i].dot(direction) > x[peak].dot(direction)) peak = i;
  }
  return 0.001 * static_cast<double>(peak);
}

TEST(PublishedTrace, HasItsRiseExcursionAndAccelerationFromEveryPostureInEveryDirection) {
  SimulatedRig rig(profile_with_ideal_sensors());
  for (const Eigen::Vector2d& posture : published_postures()) {
    for (int k = 0; k < 8; ++k) {
      SCOPED_TRACE(::testing::Message()
                   << "posture " << posture.transpose() << ", direction " << 45 * k << " deg");
      const double angle = k * std::numbers::pi / 4;
      const Trace t = trace(rig, rig.program(posture, angle));
      const double excursion = largest_norm(t.displacement);
      EXPECT_GT(excursion, 0.005);
      EXPECT_LT(excursion, 0.010);
      const double rise = time_of_first_peak(t.displacement, {std::cos(angle), std::sin(angle)});
      EXPECT_GT(rise, 0.16);
      EXPECT_LT(rise, 0.21);
      const double acceleration = largest_acceleration(t.displacement);
      EXPECT_GT(acceleration, 1.0);
      EXPECT_LT(acceleration, 1.8);
    }
  }
}

TEST(PublishedTrace, IsTheSameAtTheHighestRateOfTheLoop) {
  simulation::Profile profile = profile_with_ideal_sensors();
  profile.loop_rate = 4000.0;
  profile.sample_divider = 4;  // 1 kHz, as the figures below are taken.
  SimulatedRig rig(profile);
  for (const Eigen::Vector2d& posture : published_postures()) {
    for (int k = 0; k < 8; k += 2) {
      SCOPED_TRACE(::testing::Message()
                   << "posture " << posture.transpose() << ", direction " << 45 * k << " deg");
      const double angle = k * std::numbers::pi / 4;
      const Trace t = trace(rig, rig.program(posture, angle));
      const double excursion = largest_norm(t.displacement);
      EXPECT_GT(excursion, 0.005);
      EXPECT_LT(excursion, 0.010);
      const double rise = time_of_first_peak(t.displacement, {std::cos(angle), std::sin(angle)});
      EXPECT_GT(rise, 0.16);
      EXPECT_LT(rise, 0.21);
      const double acceleration = largest_acceleration(t.displacement);
      EXPECT_GT(acceleration, 1.0);
      EXPECT_LT(acceleration, 1.8);
    }
  }
}

TEST(PublishedTrace, IsUnderdampedAndStaysWhereItIsHeld) {
  SimulatedRig rig(profile_with_ideal_sensors());
  const Trace t = trace(rig, rig.program());
  std::vector<double> x;
  std::transform(t.displacement.begin(), t.displacement.end(), std::back_inserter(x),
                 [](const Eigen::Vector2d& d) { return d.x(); });
  const double end = x.back();
  EXPECT_GT(end, 0.003);
  EXPECT_LT(end, 0.005);
  const auto first_peak = std::max_element(x.begin(), x.begin() + 300);
  const auto first_trough = std::min_element(first_peak, first_peak + 300);
  EXPECT_GT(*first_peak, 1.3 * end);
  EXPECT_LT(*first_trough, 0.9 * end);
}

TEST(PublishedTrace, FindsNegligibleForceBeforeTheOnset) {
  SimulatedRig rig;
  for (const Eigen::Vector2d& posture : published_postures()) {
    TrialProgram program = rig.program(posture);
    program.wait = 2.0;
    const Trace t = trace(rig, program);
    ASSERT_GE(t.force_before.size(), 200U);
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (auto f = t.force_before.end() - 100; f != t.force_before.end(); ++f) mean += *f / 100.0;
    // The sensor's own noise is 0.05 N a sample; its mean over 100 has a standard deviation of 0.005 N.
    EXPECT_LT(mean.norm(), 0.05) << posture.transpose();
  }
}

TEST(PublishedTrace, StaysWithinTheExcursionAsThePublishedSensorsShowIt) {
  SimulatedRig rig;
  for (const Eigen::Vector2d& posture : published_postures()) {
    for (int k = 0; k < 8; ++k) {
      const Trace t = trace(rig, rig.program(posture, k * std::numbers::pi / 4));
      const double excursion = largest_norm(t.displacement);
      EXPECT_GT(excursion, 0.005);
      EXPECT_LT(excursion, 0.010);
    }
  }
}

}  // namespace
}  // namespace tonus::control
