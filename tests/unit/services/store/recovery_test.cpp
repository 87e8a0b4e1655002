#include "services/store/recovery.hpp"

#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <random>

#include "services/store/open_store.hpp"
#include "services/store/session_reader.hpp"
#include "services/store/sqlite_pages.hpp"
#include "services/verification/verification.hpp"
#include "tests/support/made_up_session/made_up_session.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::store {
namespace {

namespace fs = std::filesystem;

class RecoveryTest : public ::testing::Test {
 protected:
  RecoveryTest() : file_(folder_ / "archive.sqlite"), target_(folder_ / "new.sqlite") {
    auto store = store::open_store_for_writing(file_.string());
    EXPECT_TRUE(store) << store.error().message;
    record_ = made_up::put_session(**store, made_up::unloaded_session());
  }

  /// Changes the file's bytes in place.
  void damage(const std::function<void(std::string&)>& change) {
    std::ifstream in(file_, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    in.close();
    change(bytes);
    std::ofstream(file_, std::ios::binary | std::ios::trunc) << bytes;
  }

  Recovery recover() {
    const auto recovery = recover_archive(file_, target_);
    EXPECT_TRUE(recovery) << recovery.error().message;
    return recovery ? *recovery : Recovery{};
  }

  verification::Verification verify_target() {
    auto store = store::open_store_for_reading(target_.string());
    EXPECT_TRUE(store) << store.error().message;
    if (!store) return {};
    const auto v = verification::verify_session(**store, record_);
    EXPECT_TRUE(v) << v.error().message;
    return v ? *v : verification::Verification{};
  }

  ::tonus::testing::TemporaryFolder folder_;
  fs::path file_;
  fs::path target_;
  store::SessionRecord record_;
};

// 16 trials of 650 samples in blocks of 50 make 208 blocks.
constexpr std::uint64_t kBlocks = 208;

TEST_F(RecoveryTest, OfASoundFileLosesNothing) {
  const auto recovery = recover();
  EXPECT_TRUE(recovery.is_whole());
  EXPECT_EQ(recovery.blocks, kBlocks);
  EXPECT_EQ(recovery.sessions, 1U);
  EXPECT_EQ(recovery.trials, 16U);
  const auto v = verify_target();
  EXPECT_TRUE(v.is_well()) << v.problems.front();
}

TEST_F(RecoveryTest, NeedsNoHeader) {
  damage([](std::string& bytes) { std::fill_n(bytes.begin(), 100, '\xA5'); });
  const auto recovery = recover();
  EXPECT_FALSE(recovery.has_header);
  EXPECT_EQ(recovery.blocks, kBlocks);
  EXPECT_TRUE(verify_target().is_well());
}

TEST_F(RecoveryTest, NeedsNoneOfTheFilesOwnTrees) {
  // The first page has the schema, the inner nodes of tables are of type 5, indexes of types 2 and 10.
  damage([](std::string& bytes) {
    std::fill_n(bytes.begin(), 4096, '\0');
    for (std::size_t page = 4096; page < bytes.size(); page += 4096) {
      if (bytes[page] == 2 || bytes[page] == 5 || bytes[page] == 10) std::fill_n(&bytes[page], 4096, '\xFF');
    }
  });
  const auto recovery = recover();
  EXPECT_EQ(recovery.blocks, kBlocks);
  EXPECT_TRUE(verify_target().is_well());
}

TEST_F(RecoveryTest, OfATruncatedFileKeepsWhatIsLeftAndSaysWhatIsCutOff) {
  damage([](std::string& bytes) { bytes.resize(bytes.size() * 6 / 10); });
  const auto recovery = recover();
  EXPECT_FALSE(recovery.is_whole());
  EXPECT_GT(recovery.pages_expected, recovery.pages);
  EXPECT_GT(recovery.blocks, kBlocks / 4);
  EXPECT_LT(recovery.blocks, kBlocks);
}

TEST_F(RecoveryTest, ListsTheBlockAndTheSamplesThatAFlippedBitCosts) {
  // One bit of a sample in the middle of the file.
  auto store = store::open_store_for_reading(file_.string());
  ASSERT_TRUE(store);
  std::string needle;
  const auto visited =
      (*store)->visit_blocks({{record_.rig, 7}, {5650, 5651}}, [&](const store::Block& block) {
        const auto* bytes = reinterpret_cast<const char*>(block.payload->data());
        needle.assign(bytes + 4 + 48, 16);  // epoch and first sequence number, which only this block has
        return Result<void>();
      });
  ASSERT_TRUE(visited);
  store->reset();
  damage([&](std::string& bytes) {
    const auto at = bytes.find(needle);
    ASSERT_NE(at, std::string::npos);
    bytes[at + 300] = static_cast<char>(bytes[at + 300] ^ 4);
  });
  const auto recovery = recover();
  EXPECT_FALSE(recovery.is_whole());
  EXPECT_EQ(recovery.blocks, kBlocks - 1);
  ASSERT_EQ(recovery.lost_blocks.size(), 1U);
  EXPECT_EQ(recovery.lost_blocks[0].first, recovery.lost_blocks[0].last);
  const auto lost = std::find_if(recovery.lost_samples.begin(), recovery.lost_samples.end(),
                                 [](const LostSamples& l) { return l.range.first == 5650; });
  ASSERT_NE(lost, recovery.lost_samples.end());
  EXPECT_EQ(lost->range.end, 5700U);
  ASSERT_EQ(recovery.incomplete_trials.size(), 1U);
  EXPECT_NE(recovery.incomplete_trials[0].find("trial 8: 50 of 650 samples missing"), std::string::npos)
      << recovery.incomplete_trials[0];
}

TEST_F(RecoveryTest, OfOverwrittenPagesListsRowsAndLeavesTheRestAsItWas) {
  damage([](std::string& bytes) {
    std::mt19937_64 generator(11);
    for (std::size_t page = bytes.size() / 4096 / 2, end = page + 12; page < end; ++page) {
      for (std::size_t i = 0; i < 4096; ++i) bytes[page * 4096 + i] = static_cast<char>(generator());
    }
  });
  const auto recovery = recover();
  EXPECT_FALSE(recovery.is_whole());
  EXPECT_FALSE(recovery.lost_blocks.empty() && recovery.lost_messages.empty());
  EXPECT_GT(recovery.blocks, kBlocks / 2);
  std::uint64_t lost = 0;
  for (const auto& range : recovery.lost_blocks)
    lost += static_cast<std::uint64_t>(range.last - range.first + 1);
  EXPECT_EQ(recovery.blocks + lost, kBlocks);
}

TEST_F(RecoveryTest, TakesWhatIsOnlyInTheWriteAheadLog) {
  const fs::path live = folder_ / "live.sqlite";
  auto store = store::open_store_for_writing(live.string());
  ASSERT_TRUE(store) << store.error().message;
  const auto record = made_up::put_session(**store, made_up::unloaded_session());
  // As after a power failure: both files as they lie there while the archive has them open.
  fs::copy(live, folder_ / "cut.sqlite");
  fs::copy(live.string() + "-wal", folder_ / "cut.sqlite-wal");
  const auto recovery = recover_archive(folder_ / "cut.sqlite", target_);
  ASSERT_TRUE(recovery) << recovery.error().message;
  EXPECT_GT(recovery->pages_from_log, 0U);
  EXPECT_EQ(recovery->blocks, kBlocks);
  EXPECT_TRUE(verify_target().is_well());
}

TEST_F(RecoveryTest, RefusesWhatHoldsNothingOfAnArchive) {
  damage([](std::string& bytes) { std::fill(bytes.begin(), bytes.end(), 'x'); });
  const auto recovery = recover_archive(file_, target_);
  ASSERT_FALSE(recovery);
  EXPECT_EQ(recovery.error().code, ErrorCode::kDataLoss);
  EXPECT_FALSE(fs::exists(target_));
}

TEST_F(RecoveryTest, RefusesATargetThatIsThere) {
  std::ofstream(target_) << "mine";
  const auto recovery = recover_archive(file_, target_);
  ASSERT_FALSE(recovery);
  EXPECT_EQ(recovery.error().code, ErrorCode::kAlreadyExists);
}

TEST_F(RecoveryTest, RefusesAFileThatIsNotThere) {
  const auto recovery = recover_archive(folder_ / "nowhere", target_);
  ASSERT_FALSE(recovery);
  EXPECT_EQ(recovery.error().code, ErrorCode::kNotFound);
}

TEST_F(RecoveryTest, OfAnyDamageMakesAFileThatOpensOrSaysWhyNot) {
  std::ifstream in(file_, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  constexpr unsigned kSeeds = 60;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    std::mt19937_64 generator(seed);
    std::string bytes = whole;
    const std::size_t spots = 1 + generator() % 400;
    for (std::size_t i = 0; i < spots; ++i)
      bytes[generator() % bytes.size()] = static_cast<char>(generator());
    if (generator() % 4 == 0) bytes.resize(generator() % bytes.size());
    std::ofstream(file_, std::ios::binary | std::ios::trunc) << bytes;
    const auto recovery = recover_archive(file_, target_);
    if (!recovery) {
      EXPECT_FALSE(recovery.error().message.empty()) << seed;
    } else {
      auto store = store::open_store_for_reading(target_.string());
      ASSERT_TRUE(store) << seed << ": " << store.error().message;
      std::uint64_t messages = 0;
      const auto visited = (*store)->visit_messages({}, [&messages](const store::Message&) {
        ++messages;
        return Result<void>();
      });
      ASSERT_TRUE(visited) << seed << ": " << visited.error().message;
      EXPECT_EQ(messages, recovery->messages) << seed;
    }
    for (const char* suffix : {"", "-wal", "-shm"}) fs::remove(target_.string() + suffix);
  }
}

}  // namespace
}  // namespace tonus::store
