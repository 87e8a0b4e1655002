#include <algorithm>
#include <gtest/gtest.h>
#include <signal.h>

#include "services/store/open_store.hpp"
#include "tests/integration/demo_run.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kLimit{60};

/// Every stream of the archive holds each sample number from its first to its last.
void expect_every_sample(const std::filesystem::path& store_file) {
  auto store = store::open_store_for_reading(store_file.string());
  ASSERT_TRUE(store) << store.error().message;
  const auto streams = (*store)->streams();
  ASSERT_TRUE(streams) << streams.error().message;
  ASSERT_FALSE(streams->empty());
  for (const auto& stream : *streams) {
    ASSERT_EQ(stream.coverage.ranges().size(), 1U);
    const auto whole = stream.coverage.ranges().front();
    EXPECT_EQ(whole.first, stream.origin);
    // The blocks themselves hold what the coverage claims.
    std::uint64_t next = whole.first;
    const auto visited =
        (*store)->visit_blocks({stream.key, whole}, [&](const store::Block& block) -> Result<void> {
          EXPECT_LE(block.first_sequence, next);
          next = std::max(next, block.range().end);
          return {};
        });
    EXPECT_TRUE(visited) << visited.error().message;
    EXPECT_EQ(next, whole.end);
  }
}

class KilledInMidSession : public ::testing::TestWithParam<const char*> {};

TEST_P(KilledInMidSession, TheSessionEndsAndTheArchiveHoldsEverySample) {
  DemoRun run({source_file("deploy/protocols/unloaded.toml").string(), "--profile",
               source_file("deploy/profiles/default.toml").string()});
  ASSERT_TRUE(run.process().wait_for_output("trials: ", kLimit)) << run.everything_printed();
  const pid_t victim = child_named(run.process().id(), GetParam());
  ASSERT_NE(victim, 0);
  ASSERT_EQ(kill(victim, SIGKILL), 0);
  ASSERT_EQ(run.finish(), 0) << run.everything_printed();
  EXPECT_NE(run.process().output().find("was ended by signal 9"), std::string::npos);
  EXPECT_NE(run.process().output().find("80 trials"), std::string::npos);
  expect_truth_within(run.results(), 0.04);
  expect_every_sample(run.folder() / "data" / "archive.sqlite");
}

INSTANTIATE_TEST_SUITE_P(, KilledInMidSession,
                         ::testing::Values("tonus-identification", "tonus-archive", "tonus-scheduler",
                                           "tonus-rig-agent"),
                         [](const auto& instance) {
                           std::string name = instance.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace tonus::testing
