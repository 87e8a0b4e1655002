#include "rig_agent/agent/spool.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <string>

#include "tests/support/temporary_folder.hpp"

namespace tonus::rig {
namespace {

std::span<const std::byte> bytes(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

std::string text(std::span<const std::byte> payload) {
  return {reinterpret_cast<const char*>(payload.data()), payload.size()};
}

/// Blocks of ten samples; a block's payload is its number.
Result<void> append_blocks(Spool& spool, std::uint64_t epoch, std::uint64_t from, std::uint64_t count) {
  for (std::uint64_t i = from; i < from + count; ++i) {
    if (auto kept = spool.append(epoch, 10 * i, 10, {bytes(std::to_string(i)), {}}); !kept) return kept;
  }
  return {};
}

std::vector<std::string> read(const Spool& spool, std::uint64_t epoch, std::uint64_t first,
                              std::uint64_t last) {
  std::vector<std::string> payloads;
  EXPECT_TRUE(spool.read(epoch, first, last, [&](const Spool::Messages& messages) {
    payloads.push_back(text(messages.samples));
  }));
  return payloads;
}

class SpoolTest : public ::testing::Test {
 protected:
  SpoolOptions options(std::uint64_t retained = 0) {
    return {.folder = folder_.path(), .max_bytes = 4000, .retained_bytes = retained, .segment_bytes = 400};
  }
  testing::TemporaryFolder folder_;
};

TEST_F(SpoolTest, GivesEveryBlockThatHoldsAnyOfTheSamplesAskedFor) {
  auto spool = Spool::open(options());
  ASSERT_TRUE(spool && append_blocks(*spool, 1, 0, 50));
  EXPECT_EQ(read(*spool, 1, 95, 110), (std::vector<std::string>{"9", "10", "11"}));
  EXPECT_EQ(read(*spool, 1, 490, 9999), std::vector<std::string>{"49"});
  EXPECT_TRUE(read(*spool, 2, 0, 100).empty());
}

TEST_F(SpoolTest, IsThereAgainAfterTheProgramsDeath) {
  {
    auto spool = Spool::open(options());
    ASSERT_TRUE(spool && append_blocks(*spool, 7, 0, 30));
  }
  auto again = Spool::open(options());
  ASSERT_TRUE(again);
  EXPECT_EQ(read(*again, 7, 0, 299).size(), 30U);
  EXPECT_EQ(again->last_sequence(7), 299U);
}

TEST_F(SpoolTest, ForgetsOnlyWhatIsReceived) {
  auto spool = Spool::open(options());
  ASSERT_TRUE(spool && append_blocks(*spool, 1, 0, 60));
  const auto before = spool->bytes();
  EXPECT_TRUE(spool->received(1, 0, 200));
  EXPECT_LT(spool->bytes(), before);
  EXPECT_EQ(read(*spool, 1, 200, 599).size(), 40U);
}

TEST_F(SpoolTest, ForgetsNothingForAReceiptOfSamplesThatItNeverKept) {
  auto spool = Spool::open(options());
  ASSERT_TRUE(spool && append_blocks(*spool, 1, 0, 60));
  const auto before = spool->bytes();
  EXPECT_FALSE(spool->received(1, 0, 601)) << "one more than there are";
  EXPECT_FALSE(spool->received(1, 0, std::numeric_limits<std::uint64_t>::max()));
  EXPECT_FALSE(spool->received(2, 0, 10)) << "another epoch";
  ASSERT_TRUE(append_blocks(*spool, 1, 60, 60));
  EXPECT_GE(spool->bytes(), 2 * before);
  EXPECT_EQ(read(*spool, 1, 0, 1199).size(), 120U) << "nor does it count for samples that come later";
}

TEST_F(SpoolTest, ForgetsNothingForAReceiptThatLeavesOutEarlierSamples) {
  auto spool = Spool::open(options());
  ASSERT_TRUE(spool && append_blocks(*spool, 1, 0, 60));
  const auto before = spool->bytes();
  EXPECT_FALSE(spool->received(1, 100, 600)) << "0 to 99 have no receipt";
  EXPECT_EQ(spool->bytes(), before);
  EXPECT_TRUE(spool->received(1, 0, 100));
  EXPECT_TRUE(spool->received(1, 100, 600));
  EXPECT_LT(spool->bytes(), before);
}

TEST_F(SpoolTest, KeepsReceivedSamplesWhileThereIsRoom) {
  auto spool = Spool::open(options(1 << 20));
  ASSERT_TRUE(spool && append_blocks(*spool, 1, 0, 60));
  EXPECT_TRUE(spool->received(1, 0, 600));
  EXPECT_EQ(read(*spool, 1, 0, 599).size(), 60U);
}

TEST_F(SpoolTest, IsFullWhenNothingMayBeForgottenAndStillKeepsWhatComes) {
  auto spool = Spool::open(options());
  ASSERT_TRUE(spool && append_blocks(*spool, 1, 0, 200));
  EXPECT_TRUE(spool->is_full());
  ASSERT_TRUE(append_blocks(*spool, 1, 200, 1));
  EXPECT_EQ(read(*spool, 1, 0, 2009).size(), 201U);
  EXPECT_TRUE(spool->received(1, 0, 2010));
  EXPECT_FALSE(spool->is_full());
}

TEST_F(SpoolTest, FreesReceivedSamplesHoweverSmallItIs) {
  for (const std::uint64_t most : {1000U, 100'000U, 3'000'000U}) {
    const testing::TemporaryFolder folder;
    auto spool = Spool::open({.folder = folder.path(), .max_bytes = most});
    std::uint64_t blocks = 0;
    const std::string payload(400, 'x');
    for (; !spool->is_full(); ++blocks) ASSERT_TRUE(spool->append(1, 10 * blocks, 10, {bytes(payload), {}}));
    EXPECT_TRUE(spool->received(1, 0, 10 * blocks));
    EXPECT_FALSE(spool->is_full()) << most;
    EXPECT_LE(spool->bytes(), most / 2 + 500) << most;
  }
}

TEST_F(SpoolTest, KeepsAllBlocksButTheDamagedOne) {
  {
    auto spool = Spool::open({.folder = folder_.path()});
    ASSERT_TRUE(spool && append_blocks(*spool, 7, 0, 40));
  }
  const auto file = std::filesystem::directory_iterator(folder_.path())->path();
  std::fstream bits(file, std::ios::in | std::ios::out | std::ios::binary);
  bits.seekp(200);
  bits.put('\x7f');
  bits.close();
  auto again = Spool::open({.folder = folder_.path()});
  ASSERT_TRUE(again);
  EXPECT_EQ(read(*again, 7, 0, 399).size(), 39U);
  EXPECT_EQ(again->last_sequence(7), 399U);
  const auto left = again->left_behind(8);
  ASSERT_EQ(left.size(), 1U);
  EXPECT_EQ(left[0].last_sequence, 399U);
}

TEST_F(SpoolTest, LeavesOutRecordsThatCanBeNoBlockOfSamples) {
  {
    auto spool = Spool::open({.folder = folder_.path()});
    ASSERT_TRUE(spool && append_blocks(*spool, 7, 3, 2));
    // Good records all of them: no samples, samples that are there already, numbers beyond all.
    ASSERT_TRUE(spool->append(7, 50, 0, {bytes("none"), {}}));
    ASSERT_TRUE(spool->append(7, 20, 10, {bytes("before"), {}}));
    ASSERT_TRUE(spool->append(7, std::numeric_limits<std::uint64_t>::max() - 3, 10, {bytes("beyond"), {}}));
    ASSERT_TRUE(append_blocks(*spool, 7, 5, 1));
  }
  const auto again = Spool::open({.folder = folder_.path()});
  ASSERT_TRUE(again);
  EXPECT_EQ(read(*again, 7, 0, std::numeric_limits<std::uint64_t>::max()),
            (std::vector<std::string>{"3", "4", "5"}));
  const auto left = again->left_behind(8);
  ASSERT_EQ(left.size(), 1U);
  EXPECT_EQ(left[0].first_sequence, 30U);
  EXPECT_EQ(left[0].last_sequence, 59U);
}

TEST_F(SpoolTest, TellsWhatEarlierRunsLeftWithoutAReceipt) {
  {
    auto spool = Spool::open(options());
    ASSERT_TRUE(spool && append_blocks(*spool, 1, 0, 5) && append_blocks(*spool, 2, 0, 5));
  }
  auto spool = Spool::open(options());
  EXPECT_TRUE(spool->received(1, 0, 50));
  ASSERT_TRUE(append_blocks(*spool, 3, 0, 1));
  const auto left = spool->left_behind(3);
  ASSERT_EQ(left.size(), 1U);
  EXPECT_EQ(left[0].epoch, 2U);
  EXPECT_EQ(left[0].first_sequence, 0U);
  EXPECT_EQ(left[0].last_sequence, 49U);
}

TEST_F(SpoolTest, KeepsTheAuxiliaryValuesOfABlockWithItsSamplesAndLosesThemTogether) {
  {
    auto spool = Spool::open(options());
    ASSERT_TRUE(spool);
    for (std::uint64_t i = 0; i < 3; ++i) {
      const std::string samples = "samples " + std::to_string(i);
      const std::string values = "values " + std::to_string(i);
      ASSERT_TRUE(spool->append(7, 10 * i, 10, {bytes(samples), bytes(values)}));
    }
  }
  const auto file = std::filesystem::directory_iterator(folder_.path())->path();
  {
    std::fstream damaged(file, std::ios::in | std::ios::out | std::ios::binary);
    std::string content((std::istreambuf_iterator<char>(damaged)), {});
    damaged.clear();
    damaged.seekp(static_cast<std::streamoff>(content.find("values 1")));
    damaged << "V";
  }
  auto again = Spool::open(options());
  ASSERT_TRUE(again);
  std::vector<std::string> left;
  ASSERT_TRUE(again->read(7, 0, 29, [&](const Spool::Messages& messages) {
    left.push_back(text(messages.samples) + ", " + text(messages.auxiliary));
  }));
  EXPECT_EQ(left, (std::vector<std::string>{"samples 0, values 0", "samples 2, values 2"}));
}

TEST_F(SpoolTest, ReadsARecordOfAVersionThatKnewNoAuxiliaryValues) {
  // first sequence, number of samples (8 bytes each), and the samples' message behind them
  const std::string payload = "samples";
  std::string content(16, '\0');
  content[0] = 20;
  content[8] = 10;
  content += payload;
  {
    auto file = RecordFile::open(folder_ / "00000000000000000007-00000000000000000020.spool", {});
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->append(bytes(content)));
  }
  auto spool = Spool::open(options());
  ASSERT_TRUE(spool);
  bool has_auxiliary = true;
  ASSERT_TRUE(spool->read(7, 20, 29, [&](const Spool::Messages& messages) {
    EXPECT_EQ(text(messages.samples), payload);
    has_auxiliary = !messages.auxiliary.empty();
  }));
  EXPECT_FALSE(has_auxiliary);
}

}  // namespace
}  // namespace tonus::rig
