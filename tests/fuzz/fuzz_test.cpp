#include <gtest/gtest.h>

#include "tests/fuzz/target.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

/// Short slices of the fuzzing campaign; the long one is `archive_fuzz`.
namespace tonus::fuzz {
namespace {

/// Some are refused, some are taken, and none does harm.
void fuzz(Target& target, std::uint64_t inputs) {
  std::uint64_t refused = 0;
  for (std::uint64_t seed = 1; seed <= inputs; ++seed) {
    Damage damage(seed);
    const auto outcome = target.run(damage);
    ASSERT_TRUE(outcome) << "seed " << seed << ": " << outcome.error().message;
    refused += *outcome ? 1 : 0;
  }
  EXPECT_GT(refused, inputs / 20);
  EXPECT_LT(refused, inputs);
}

TEST(Fuzz, MessagesThatAreDamagedAreRefusedWithoutHarm) { fuzz(*make_message_target(), 20'000); }

TEST(Fuzz, StoresThatAreDamagedAreRefusedWithoutHarm) {
  const testing::TemporaryFolder folder;
  fuzz(*make_store_target(folder.path()), 150);
}

TEST(Fuzz, DatasetsThatAreDamagedAreRefusedWithoutHarm) {
  const testing::TemporaryFolder folder;
  fuzz(*make_dataset_target(folder.path()), 500);
}

TEST(Fuzz, ProgramsGivenDamagedInputsDoNotDie) {
  const testing::TemporaryFolder folder;
  const auto target = make_program_target(folder.path(), testing::program("tonus"));
  if (!target) GTEST_SKIP() << "tonus has neither recover nor import";
  fuzz(*target, 30);
}

}  // namespace
}  // namespace tonus::fuzz
