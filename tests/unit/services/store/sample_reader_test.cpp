#include "services/store/sample_reader.hpp"

#include <gtest/gtest.h>

#include "services/bus/typed.hpp"
#include "services/core/crc32c.hpp"
#include "services/store/memory_store.hpp"
#include "tests/unit/services/store/made_up.hpp"

namespace tonus::store {
namespace {

using testing::kStream;

class SampleReader : public ::testing::Test {
 protected:
  /// A block whose samples' stamps are their numbers.
  void put(std::uint64_t first, std::uint64_t end) {
    v1::SampleBlock wire;
    wire.rig_id(kStream.rig);
    wire.epoch(kStream.epoch);
    wire.first_sequence(first);
    for (std::uint64_t i = first; i < end; ++i) {
      wire.samples().emplace_back();
      wire.samples().back().acquisition_ns(static_cast<std::int64_t>(i));
    }
    Block block = testing::block_of(first, static_cast<std::uint32_t>(end - first));
    block.payload = std::make_shared<const bus::Payload>(*bus::encode(wire));
    block.checksum = crc32c(*block.payload);
    Batch batch;
    batch.streams = {{kStream, 0, {}, 0, 0}};
    batch.blocks = {block};
    ASSERT_TRUE(store_.commit(batch));
  }

  [[nodiscard]] std::string refusal(SequenceRange range) {
    const auto samples = read_samples(store_, kStream, range);
    if (samples) return "nothing refused";
    EXPECT_EQ(samples.error().code, ErrorCode::kDataLoss);
    return samples.error().message;
  }

  MemoryStore store_;
};

TEST_F(SampleReader, GivesEachSampleOnceAndInOrder) {
  put(40, 60);
  put(0, 20);
  put(10, 30);
  put(10, 15);
  put(30, 40);
  const auto samples = read_samples(store_, kStream, {5, 55});
  ASSERT_TRUE(samples) << samples.error().message;
  ASSERT_EQ(samples->size(), 50U);
  for (std::size_t i = 0; i < samples->size(); ++i)
    EXPECT_EQ((*samples)[i].acquisition_ns(), static_cast<std::int64_t>(5 + i));
}

TEST_F(SampleReader, NamesMissingSamples) {
  put(0, 20);
  put(30, 40);
  const std::string stream =
      " of rig " + to_hex(kStream.rig) + ", epoch " + std::to_string(kStream.epoch) + " are missing";
  EXPECT_EQ(refusal({0, 40}), "store ':memory:': samples 20 to 29" + stream);
  EXPECT_EQ(refusal({35, 60}), "store ':memory:': samples 40 to 59" + stream);
  EXPECT_EQ(refusal({100, 102}), "store ':memory:': samples 100 to 101" + stream);
}

}  // namespace
}  // namespace tonus::store
