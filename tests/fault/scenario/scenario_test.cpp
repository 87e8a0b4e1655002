#include "tests/fault/scenario/scenario.hpp"

#include <gtest/gtest.h>

namespace tonus::testing {
namespace {

TEST(Scenario, OfOneSeedIsTheSameAndReadsBackAsItWasWritten) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const std::string text = to_text(draw_scenario(seed, 4));
    EXPECT_EQ(to_text(draw_scenario(seed, 4)), text);
    const auto read = parse_scenario(text);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(to_text(*read), text);
  }
  EXPECT_NE(to_text(draw_scenario(1, 4)), to_text(draw_scenario(2, 4)));
}

TEST(Scenario, RefusesAStepThatIsNone) {
  for (const char* text : {"kill", "kill gateway after 1", "pause archive after 1", "restart after soon",
                           "stop after 1 for 2", "explode after 1", "kill archive after -1"}) {
    EXPECT_FALSE(parse_scenario(text)) << text;
  }
}

class FaultScenarios : public ::testing::TestWithParam<const char*> {};

// A short slice; fault_scenarios is the long form.
TEST_P(FaultScenarios, NothingMovesUnaskedAndNothingIsLostAfterKillsOfEveryKind) {
  const auto scenario =
      parse_scenario("kill archive after 0.50; kill rig-agent after 1.00; kill scheduler after 0.50");
  ASSERT_TRUE(scenario);
  const auto broken = run_scenario(*scenario, GetParam());
  ASSERT_TRUE(broken) << broken.error().message;
  EXPECT_EQ(*broken, "");
}

INSTANTIATE_TEST_SUITE_P(, FaultScenarios, ::testing::Values("fastdds", "cyclonedds"),
                         [](const auto& instance) { return std::string(instance.param); });

}  // namespace
}  // namespace tonus::testing
