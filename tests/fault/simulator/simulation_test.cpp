#include "tests/fault/simulator/simulation.hpp"

#include <filesystem>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include "tests/support/temporary_folder.hpp"

namespace tonus::simulator {
namespace {

class Simulation : public ::testing::Test {
 protected:
  void SetUp() override {
    spdlog::set_level(spdlog::level::off);
    std::filesystem::current_path(folder_.path());
  }
  void TearDown() override { std::filesystem::current_path("/"); }

  testing::TemporaryFolder folder_;
};

TEST_F(Simulation, OfASessionWithoutFaultsCountsEveryTrial) {
  const Outcome outcome = simulate({}, {.seed = 1, .trials = 3});
  EXPECT_EQ(outcome.broken, "");
  EXPECT_EQ(outcome.trials, 3U);
}

TEST_F(Simulation, OfOneSeedHasOneTrace) {
  const auto scenario = testing::draw_simulated_scenario(7, 5);
  const Outcome first = simulate(scenario, {.seed = 7, .trials = 3});
  const Outcome second = simulate(scenario, {.seed = 7, .trials = 3});
  EXPECT_EQ(first.hash, second.hash);
  EXPECT_EQ(first.simulated, second.simulated);
  EXPECT_NE(first.hash, simulate(scenario, {.seed = 8, .trials = 3}).hash);
}

TEST_F(Simulation, OfATornWriteTakesUpTheSessionAgain) {
  const auto scenario = testing::parse_scenario(
      "tear scheduler after 0.50 at 3; tear rig-agent after 4.00 at 5; tear archive after 4.00 at 2");
  ASSERT_TRUE(scenario) << scenario.error().message;
  const Outcome outcome = simulate(*scenario, {.seed = 2, .trials = 4});
  EXPECT_EQ(outcome.broken, "");
  EXPECT_EQ(outcome.trials, 4U);
}

// A short slice; fault_simulator is the long form.
TEST_F(Simulation, HoldsItsInvariantsUnderDrawnFaults) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const auto scenario = testing::draw_simulated_scenario(seed, 4);
    EXPECT_EQ(simulate(scenario, {.seed = seed, .trials = 3}).broken, "") << testing::to_text(scenario);
  }
}

}  // namespace
}  // namespace tonus::simulator
