#include "services/store/block_header.hpp"

#include <gtest/gtest.h>
#include <random>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "tests/unit/services/store/made_up.hpp"

namespace tonus::store {
namespace {

using testing::kEpoch;
using testing::kRig;
using testing::kSession;

bus::Payload payload_with(std::size_t samples, std::uint64_t first = 77) {
  v1::SampleBlock block;
  block.rig_id(kRig);
  block.session_id(kSession);
  block.trial_id(id_of("trial"));
  block.epoch(kEpoch);
  block.first_sequence(first);
  block.is_resent(true);
  block.send_ns(5);
  block.samples().resize(samples);
  for (std::size_t i = 0; i < samples; ++i) block.samples()[i].acquisition_ns(static_cast<std::int64_t>(i));
  return *bus::encode(block);
}

TEST(BlockHeader, SaysWhatTheBlockSays) {
  for (std::size_t samples = 1; samples <= 256; ++samples) {
    const auto header = read_block_header(payload_with(samples));
    ASSERT_TRUE(header) << header.error().message;
    EXPECT_EQ(header->stream, (StreamKey{kRig, kEpoch}));
    EXPECT_EQ(header->session, kSession);
    EXPECT_EQ(header->trial, id_of("trial"));
    EXPECT_EQ(header->first_sequence, 77U);
    EXPECT_EQ(header->count, samples);
    EXPECT_TRUE(header->is_resent);
  }
}

TEST(BlockHeader, RefusesABlockWithoutSamplesAndNumbersThatAreNonsense) {
  EXPECT_FALSE(read_block_header(payload_with(0)));
  EXPECT_FALSE(read_block_header(payload_with(1, (std::uint64_t{1} << 62U) + 1)));
  EXPECT_TRUE(read_block_header(payload_with(1, std::uint64_t{1} << 62U)));
}

TEST(BlockHeader, RefusesWhatDoesNotDecodeAndNothingElse) {
  std::mt19937_64 generator(6);
  int refused = 0;
  int taken = 0;
  for (int i = 0; i < 20'000; ++i) {
    auto payload = payload_with(generator() % 12 + 1);
    // Cut or lengthened, or a few bytes of the header and the first sample changed.
    if (generator() % 2 == 0) payload.resize(generator() % (payload.size() + 8));
    for (auto changes = generator() % 3; changes > 0 && !payload.empty(); --changes)
      payload[generator() % std::min<std::size_t>(payload.size(), 100)] = static_cast<std::byte>(generator());
    const auto decoded = bus::decode<v1::SampleBlock>(payload);
    const bool is_sense = decoded && !decoded->samples().empty() &&
                          decoded->first_sequence() <= std::uint64_t{1} << 62U &&
                          decoded->epoch() <= std::uint64_t{1} << 62U;
    const auto header = read_block_header(payload);
    ASSERT_EQ(header.has_value(), is_sense) << "case " << i << ": " << (header ? "" : header.error().message);
    (header ? taken : refused) += 1;
    if (!header) continue;
    EXPECT_EQ(header->stream.rig, decoded->rig_id());
    EXPECT_EQ(header->stream.epoch, decoded->epoch());
    EXPECT_EQ(header->first_sequence, decoded->first_sequence());
    EXPECT_EQ(header->count, decoded->samples().size());
    EXPECT_EQ(header->is_resent, decoded->is_resent());
  }
  EXPECT_GT(refused, 2000);
  EXPECT_GT(taken, 2000);
}

bus::Payload values_of(std::uint32_t samples, std::size_t values, std::uint64_t first = 77) {
  v1::AuxiliaryBlock block;
  block.rig_id(kRig);
  block.session_id(kSession);
  block.trial_id(id_of("trial"));
  block.epoch(kEpoch);
  block.first_sequence(first);
  block.sample_count(samples);
  block.is_resent(true);
  block.values().resize(values);
  return *bus::encode(block);
}

TEST(AuxiliaryHeader, SaysWhatTheBlockSays) {
  const auto header = read_auxiliary_header(values_of(100, 1200));
  ASSERT_TRUE(header) << header.error().message;
  EXPECT_EQ(header->block.stream, (StreamKey{kRig, kEpoch}));
  EXPECT_EQ(header->block.session, kSession);
  EXPECT_EQ(header->block.trial, id_of("trial"));
  EXPECT_EQ(header->block.first_sequence, 77U);
  EXPECT_EQ(header->block.count, 100U);
  EXPECT_TRUE(header->block.is_resent);
  EXPECT_TRUE(header->block.is_auxiliary);
  EXPECT_EQ(header->values_per_sample, 12U);
}

TEST(AuxiliaryHeader, RefusesNumbersThatCannotBe) {
  EXPECT_FALSE(read_auxiliary_header(values_of(0, 12)));
  EXPECT_FALSE(read_auxiliary_header(values_of(257, 257)));
  EXPECT_FALSE(read_auxiliary_header(values_of(10, 0)));
  EXPECT_FALSE(read_auxiliary_header(values_of(10, 101)));
  EXPECT_FALSE(read_auxiliary_header(values_of(1, 1, (std::uint64_t{1} << 62U) + 1)));
}

TEST(AuxiliaryHeader, RefusesWhatDoesNotDecodeAndNothingElse) {
  std::mt19937_64 generator(7);
  int refused = 0;
  int taken = 0;
  for (int i = 0; i < 20'000; ++i) {
    const auto samples = static_cast<std::uint32_t>(generator() % 5 + 1);
    auto payload = values_of(samples, 3 * samples);
    if (generator() % 2 == 0) payload.resize(generator() % (payload.size() + 8));
    for (auto changes = generator() % 3; changes > 0 && !payload.empty(); --changes)
      payload[generator() % std::min<std::size_t>(payload.size(), 100)] = static_cast<std::byte>(generator());
    const auto wire = bus::decode<v1::AuxiliaryBlock>(payload);
    const bool is_sense = wire && wire->sample_count() >= 1 && wire->sample_count() <= 256 &&
                          !wire->values().empty() && wire->values().size() % wire->sample_count() == 0 &&
                          wire->first_sequence() <= std::uint64_t{1} << 62U &&
                          wire->epoch() <= std::uint64_t{1} << 62U;
    const auto header = read_auxiliary_header(payload);
    ASSERT_EQ(header.has_value(), is_sense) << "case " << i << ": " << (header ? "" : header.error().message);
    (header ? taken : refused) += 1;
    if (header) {
      EXPECT_EQ(header->block.count, wire->sample_count());
    }
  }
  EXPECT_GT(refused, 2000);
  EXPECT_GT(taken, 2000);
}

}  // namespace
}  // namespace tonus::store
