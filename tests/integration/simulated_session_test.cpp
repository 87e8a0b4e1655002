#include <gtest/gtest.h>

#include "tests/integration/demo_run.hpp"

namespace tonus::testing {
namespace {

constexpr double kAllowed = 0.04;  // of the largest element of each true matrix, sensor noise alone

std::vector<std::string> unloaded_session(const std::string& dds, const std::string& rig_dds, int seed) {
  return {source_file("deploy/protocols/unloaded.toml").string(),
          "--profile",
          source_file("deploy/profiles/default.toml").string(),
          "--dds",
          dds,
          "--rig-dds",
          rig_dds,
          "--seed",
          std::to_string(seed),
          "--rig-seed",
          std::to_string(seed)};
}

struct Vendors {
  const char* dds;
  const char* rig_dds;
};

class SessionOverVendors : public ::testing::TestWithParam<Vendors> {};

TEST_P(SessionOverVendors, MeasuresAllFivePosturesWithinFourPercent) {
  DemoRun run(unloaded_session(GetParam().dds, GetParam().rig_dds, 1));
  ASSERT_EQ(run.finish(), 0) << run.everything_printed();
  expect_truth_within(run.results(), kAllowed);
}

INSTANTIATE_TEST_SUITE_P(, SessionOverVendors,
                         ::testing::Values(Vendors{"fastdds", "fastdds"}, Vendors{"cyclonedds", "cyclonedds"},
                                           Vendors{"fastdds", "cyclonedds"},
                                           Vendors{"cyclonedds", "fastdds"}),
                         [](const auto& instance) {
                           return std::string(instance.param.rig_dds) + "_rig_and_" + instance.param.dds +
                                  "_services";
                         });

class SessionOverSeeds : public ::testing::TestWithParam<int> {};

TEST_P(SessionOverSeeds, MeasuresAllFivePosturesWithinFourPercent) {
  DemoRun run(unloaded_session("fastdds", "fastdds", GetParam()));
  ASSERT_EQ(run.finish(), 0) << run.everything_printed();
  expect_truth_within(run.results(), kAllowed);
}

INSTANTIATE_TEST_SUITE_P(, SessionOverSeeds, ::testing::Values(2, 3, 4, 5));

}  // namespace
}  // namespace tonus::testing
