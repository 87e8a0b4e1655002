#include <csignal>
#include <gtest/gtest.h>
#include <random>
#include <sys/wait.h>
#include <unistd.h>

#include "services/archive/ingest.hpp"
#include "services/store/sqlite_store.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/store/made_up.hpp"

/// An archive that is killed while it writes: everything that it gave a receipt for is there afterwards.
namespace tonus::store {
namespace {

using testing::block_of;
using testing::kStream;
using testing::trial_of;

constexpr std::uint32_t kBlockSamples = 20;
constexpr std::uint64_t kTrialSamples = 200;

/// Takes samples and trials without end and reports each receipt's `through`; never returns.
[[noreturn]] void archive_without_end(const std::string& path, int receipts) {
  auto store = SqliteStore::open(path, SqliteStore::Access::kWrite);
  if (!store) ::_exit(2);
  ManualClock clock;
  archive::Ingest ingest(**store, clock);
  if (!ingest.recover()) ::_exit(3);
  const auto streams = (*store)->streams();
  std::uint64_t next =
      streams->empty() ? 0 : streams->front().coverage.first_missing(0) / kTrialSamples * kTrialSamples;
  while (true) {
    const auto attempt = static_cast<std::uint32_t>(next / kTrialSamples + 1);
    for (std::uint64_t end = next + kTrialSamples; next < end; next += kBlockSamples) {
      ingest.take(block_of(next, kBlockSamples, trial_id(testing::kSession, attempt)));
    }
    ingest.note_outcome(trial_of(attempt, next - kTrialSamples, next - 1));
    clock.advance(std::chrono::milliseconds(10));
    for (const auto& receipt : ingest.step().stream_receipts) {
      if (::write(receipts, &receipt.through, sizeof(receipt.through)) != sizeof(receipt.through)) ::_exit(4);
    }
  }
}

TEST(SqliteCrash, LosesNothingThatAReceiptWasGivenFor) {
  const tonus::testing::TemporaryFolder folder;
  const std::string path = folder / "study.sqlite";
  std::mt19937 generator(5);
  std::uniform_int_distribution<int> receipts_before_kill(1, 40);
  std::uint64_t highest = 0;
  for (int crash = 0; crash < 25; ++crash) {
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    if (child == 0) archive_without_end(path, ends[1]);
    ::close(ends[1]);
    std::uint64_t through = 0;
    for (int i = receipts_before_kill(generator); i > 0; --i) {
      ASSERT_EQ(::read(ends[0], &through, sizeof(through)), static_cast<ssize_t>(sizeof(through)));
      highest = std::max(highest, through);
    }
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    while (::read(ends[0], &through, sizeof(through)) == static_cast<ssize_t>(sizeof(through))) {
      highest = std::max(highest, through);  // given before it died
    }
    ::close(ends[0]);

    auto store = SqliteStore::open(path, SqliteStore::Access::kRead);
    ASSERT_TRUE(store) << store.error().message;
    Coverage stored;
    const auto visited =
        (*store)->visit_blocks({kStream, {0, highest + 100'000}}, [&](const Block& block) -> Result<void> {
          stored.add(block.range());
          return {};
        });
    ASSERT_TRUE(visited) << visited.error().message;
    EXPECT_TRUE(stored.covers({0, highest})) << "crash " << crash << ", receipts through " << highest;
    EXPECT_EQ((*store)->streams()->front().coverage, stored);
    const auto trials = (*store)->trials(testing::kSession);
    EXPECT_GE(trials->size(), highest / kTrialSamples);
    for (const TrialRecord& trial : *trials) EXPECT_TRUE(trial.is_certified && stored.covers(trial.range()));
  }
  EXPECT_GT(highest, 25 * kTrialSamples);
}

}  // namespace
}  // namespace tonus::store
