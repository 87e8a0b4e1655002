#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>

#include "rig_agent/control/auxiliary_collector.hpp"
#include "tests/support/simulated_rig.hpp"

namespace tonus::control {
namespace {

/// Gives each channel's values as the numbers of what it gave before, from 0 on.
class CountingDriver final : public drivers::Driver {
 public:
  explicit CountingDriver(std::size_t channels) : given_(channels) {}
  Result<void> configure(double /*period*/) override { return {}; }
  Result<void> activate() override { return {}; }
  void deactivate() noexcept override {}
  [[nodiscard]] drivers::Capabilities capabilities() const noexcept override { return {}; }
  [[nodiscard]] const RigGeometry& geometry() const noexcept override { return geometry_; }
  drivers::DriverStatus read(drivers::Reading& /*reading*/) noexcept override {
    return drivers::DriverStatus::kOk;
  }
  drivers::DriverStatus write(const Eigen::Vector2d& /*torque*/) noexcept override {
    return drivers::DriverStatus::kOk;
  }
  void read_auxiliary(std::span<const std::uint32_t> counts, std::span<float> values) noexcept override {
    auto value = values.begin();
    for (std::size_t i = 0; i < counts.size(); ++i)
      for (std::uint32_t k = 0; k < counts[i]; ++k) *value++ = static_cast<float>(given_[i]++);
  }

 private:
  RigGeometry geometry_;
  std::vector<int> given_;
};

std::vector<float> row_of(const AuxiliaryCollector& collector) {
  return {collector.row().begin(), collector.row().end()};
}

TEST(AuxiliaryCollector, SpreadsTheValuesOfASampleOverItsCycles) {
  // 1000 Hz loop, 200 Hz samples: 10, 5, 2 and 1 values with each sample.
  const std::vector<AuxiliaryChannel> channels{{"A", "EMG", "mV", 1.0, 2000.0},
                                               {"B", "EMG", "mV", 1.0, 1000.0},
                                               {"C", "MISC", "V", 1.0, 400.0},
                                               {"D", "MISC", "V", 1.0, 200.0}};
  CountingDriver driver(channels.size());
  AuxiliaryCollector collector(channels, 200.0, 5);
  ASSERT_EQ(collector.size(), 18U);
  collector.collect(driver, 0, true);  // takes the first sample, before which nothing was measured
  EXPECT_EQ(std::count_if(collector.row().begin(), collector.row().end(), [](float v) { return v == v; }),
            2 + 1 + 1 + 1);
  EXPECT_EQ(collector.row()[9], 1.0F);
  collector.begin_sample();
  for (std::uint64_t cycle = 1; cycle <= 5; ++cycle) collector.collect(driver, cycle, true);
  EXPECT_EQ(row_of(collector), (std::vector<float>{2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 1, 2, 3, 4, 5, 1, 2, 1}));
}

TEST(AuxiliaryCollector, KeepsNothingOfACycleThatWasNotRunInTime) {
  const std::vector<AuxiliaryChannel> channels{{"A", "EMG", "mV", 1.0, 1000.0}};
  CountingDriver driver(1);
  AuxiliaryCollector collector(channels, 200.0, 5);
  for (std::uint64_t cycle = 1; cycle <= 5; ++cycle) collector.collect(driver, cycle, cycle != 3);
  const auto row = row_of(collector);
  EXPECT_TRUE(std::isnan(row[2]));
  EXPECT_EQ(row[1], 1.0F);
  EXPECT_EQ(row[3], 3.0F);
}

simulation::Profile with_channels(unsigned divider) {
  simulation::Profile profile;
  profile.sample_divider = divider;
  for (const char* muscle : simulation::kMuscleNames)
    profile.auxiliary.push_back({muscle, "EMG", "mV", 1.0, 2000.0});
  profile.auxiliary.push_back({"Onset", "TRIG", "n/a", 1.0, 1000.0});
  return profile;
}

TEST(RigLoop, ShowsTheOnsetToOtherRecordersInTheSampleThatItNames) {
  SimulatedRig rig(with_channels(5));
  ASSERT_EQ(rig.loop().auxiliary_values(), 6U * 10U + 5U);
  std::vector<std::vector<float>> rows;
  rig.start(rig.program());
  TrialResult result;
  SampleRecord sample;
  std::vector<float> row(rig.loop().auxiliary_values());
  std::int64_t now = 0;
  for (int i = 0; i < 30'000 && !rig.loop().next_result(result); ++i) {
    rig.loop().keep_alive();
    rig.loop().step(now += 1'000'000);
    while (rig.loop().next_sample(sample, row)) rows.push_back(row);
  }
  ASSERT_EQ(result.outcome, TrialOutcome::kCompleted);
  ASSERT_TRUE(result.is_onset_marked);
  EXPECT_EQ(result.mark_sequence, result.onset_sequence);
  const auto line = [&](std::uint64_t sequence) {
    return std::vector<float>(rows[sequence].begin() + 60, rows[sequence].end());
  };
  EXPECT_EQ(line(result.mark_sequence), (std::vector<float>{0, 0, 0, 0, 1}));
  EXPECT_EQ(line(result.mark_sequence + 1), (std::vector<float>{1, 1, 1, 1, 1}));
  for (std::size_t i = 1; i < rows.size(); ++i)
    ASSERT_TRUE(std::all_of(rows[i].begin(), rows[i].end(), [](float v) { return std::isfinite(v); })) << i;
}

TEST(RigLoop, RefusesAChannelWhoseRateIsNoMultipleOfTheSampleRate) {
  auto profile = with_channels(3);
  drivers::Simulated driver(profile);
  ASSERT_TRUE(driver.configure(1.0 / profile.loop_rate));
  ASSERT_TRUE(driver.activate());
  const auto loop = RigLoop::create(driver, simulation::loop_config(profile));
  EXPECT_TRUE(loop);  // 333.3 Hz: six values each
  profile = with_channels(7);
  profile.auxiliary.resize(1);
  profile.auxiliary[0].rate = 1500.0;
  drivers::Simulated other(profile);
  ASSERT_TRUE(other.configure(1.0 / profile.loop_rate));
  ASSERT_TRUE(other.activate());
  const auto refused = RigLoop::create(other, simulation::loop_config(profile));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("rate_Hz: 1500 is not allowed"), std::string::npos)
      << refused.error().message;
}

TEST(RigLoop, HoldsTheHandleStillWhileTheSubjectContracts) {
  SimulatedRig rig(with_channels(5));
  TrialProgram program = rig.program();
  program.kind = TrialKind::kContraction;
  program.amplitude = 0.0;
  program.hold = 2.0;
  rig.start(program);
  ASSERT_TRUE(rig.step_until_phase(Phase::kPerturbing));
  const auto place = rig.loop().state().position;
  double hardest = 0.0;
  double furthest = 0.0;
  while (rig.loop().state().phase == Phase::kPerturbing) {
    rig.step();
    const auto& active = rig.driver().plant().activation();
    hardest = std::max(hardest, *std::min_element(active.begin(), active.end()));
    const auto state = rig.loop().state();
    furthest = std::max(furthest, std::hypot(state.position[0] - place[0], state.position[1] - place[1]));
  }
  TrialResult result;
  ASSERT_TRUE(rig.step_until([&] { return rig.loop().next_result(result); }));
  EXPECT_EQ(result.outcome, TrialOutcome::kCompleted);
  EXPECT_GT(hardest, 0.99);
  EXPECT_LT(furthest, 0.002);
  for (const auto& sample : rig.samples()) EXPECT_EQ(sample.commanded, (std::array<double, 2>{}));
}

}  // namespace
}  // namespace tonus::control
