#include <generated/fast/probe.h>

#include "services/bus/typed.hpp"
#include "tests/contract/bus/contract_fixture.hpp"
#include "tests/contract/bus/native_peers.hpp"

namespace tonus::bus::test {
namespace {

using bus_test::v1::Probe;
using tonus::test::eventually;

/// A carrier of the bus and a vendor's own peer of the generated type.
struct Neighbours {
  Vendor carrier;
  Vendor native;
};

std::string neighbours_name(const testing::TestParamInfo<Neighbours>& info) {
  return std::string(vendor_name(info.param.carrier)) + "_carrier_and_native_" +
         std::string(vendor_name(info.param.native));
}

class NativePeers : public testing::TestWithParam<Neighbours> {
 protected:
  void SetUp() override {
    bus_ = open_bus(bus_options(GetParam().carrier));
    const BusOptions options = bus_options(GetParam().native, nullptr, "native");
    native_ =
        GetParam().native == Vendor::kFastDds ? open_native_fast(options) : open_native_cyclone(options);
    ASSERT_TRUE(bus_ && native_);
  }
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<NativePeer> native_;
};

INSTANTIATE_TEST_SUITE_P(Pairs, NativePeers,
                         testing::Values(Neighbours{Vendor::kFastDds, Vendor::kFastDds},
                                         Neighbours{Vendor::kFastDds, Vendor::kCycloneDds},
                                         Neighbours{Vendor::kCycloneDds, Vendor::kFastDds},
                                         Neighbours{Vendor::kCycloneDds, Vendor::kCycloneDds}),
                         neighbours_name);

const Topic<Probe> kProbeTopic{topic(kNativeTopic, keep_all(100, Durability::kTransientLocal))};

/// Sizes differ from one to the next, so that padding of every length occurs.
ProbeFacts facts(std::uint64_t number) {
  ProbeFacts out{.id = key_of(static_cast<std::uint8_t>(number % 3)),
                 .sequence_number = number,
                 .note = std::string(number % 9, 'n'),
                 .values = {},
                 .tail = static_cast<std::uint8_t>(200 + number),
                 .key_hash = std::nullopt};
  for (std::uint64_t i = 0; i < number % 5; ++i) out.values.push_back(static_cast<double>(number + i) / 8);
  return out;
}

Probe probe(const ProbeFacts& facts) {
  Probe out;
  out.probe_id(facts.id);
  out.sequence_number(facts.sequence_number);
  out.note(facts.note);
  out.values(facts.values);
  out.tail(facts.tail);
  return out;
}

TEST_P(NativePeers, NativeReaderUnderstandsWhatTheBusSends) {
  auto writer = TypedWriter<Probe>::create(*bus_, kProbeTopic);
  ASSERT_TRUE(writer);
  for (std::uint64_t number = 0; number < 20; ++number) ASSERT_TRUE(writer->write(probe(facts(number))));

  std::vector<ProbeFacts> received;
  ASSERT_TRUE(eventually([&] {
    for (ProbeFacts& one : native_->take()) received.push_back(std::move(one));
    return received.size() >= 20;
  }));

  ASSERT_EQ(received.size(), 20U);
  for (ProbeFacts& one : received) {
    EXPECT_EQ(one.key_hash.value_or(one.id), one.id);
    one.key_hash.reset();
    EXPECT_EQ(one, facts(one.sequence_number));
  }
}

TEST_P(NativePeers, TheBusUnderstandsWhatANativeWriterSends) {
  auto notifier = std::make_shared<Notifier>();
  auto reader = TypedReader<Probe>::create(*bus_, kProbeTopic, notifier);
  ASSERT_TRUE(reader);
  for (std::uint64_t number = 0; number < 20; ++number) ASSERT_TRUE(native_->write(facts(number)));

  std::vector<Received<Probe>> received;
  ASSERT_TRUE(eventually([&] {
    reader->take(received);
    return received.size() >= 20;
  }));

  ASSERT_EQ(received.size(), 20U);
  for (std::uint64_t number = 0; number < 20; ++number) {
    EXPECT_EQ(received[number].value, probe(facts(number))) << number;
    EXPECT_EQ(received[number].sample.key, facts(number).id);
  }
  EXPECT_EQ(reader->status().malformed, 0U);
}

class HostilePeers : public BusContract {
 protected:
  [[nodiscard]] std::unique_ptr<RawWriter> open_raw(const TopicSpec& spec) const {
    const BusOptions options = bus_options(GetParam().writer, nullptr, "raw");
    return GetParam().writer == Vendor::kFastDds ? open_raw_fast(options, spec)
                                                 : open_raw_cyclone(options, spec);
  }
};
INSTANTIATE_TEST_SUITE_P(Pairs, HostilePeers, kNetworkPairings, pairing_name);

TEST_P(HostilePeers, MalformedPayloadsAreCountedAndTheNextGoodOneIsDelivered) {
  const TopicSpec spec = topic("contract/hostile", keep_all(64), 128);
  auto reader = make_reader(spec);
  auto raw = open_raw(spec);
  ASSERT_TRUE(raw);
  ASSERT_TRUE(
      eventually([&] { return raw->matched_readers() == 1 && reader->status().matched_writers == 1; }));
  Payload big_endian = payload(1, 1);
  big_endian[1] = std::byte{0};
  Payload unknown_encoding = payload(1, 1);
  unknown_encoding[0] = std::byte{0xff};

  ASSERT_TRUE(raw->write(payload(1, 1)));
  ASSERT_TRUE(raw->write(Payload{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}}));  // header alone
  ASSERT_TRUE(raw->write(Payload(16, std::byte{1})));  // ends within the key
  ASSERT_TRUE(raw->write(big_endian));
  ASSERT_TRUE(raw->write(unknown_encoding));
  ASSERT_TRUE(raw->write(payload(1, 1, 256)));  // over the topic's limit
  ASSERT_TRUE(raw->write(payload(1, 2)));

  EXPECT_EQ(numbers_of(receive(*reader, *notifier_, 2)), (std::vector<std::uint64_t>{1, 2}));
  EXPECT_EQ(reader->status().malformed, 5U);
  EXPECT_EQ(reader->status().received, 2U);
}

TEST_P(HostilePeers, PayloadsOfRandomMembersAreRefusedByTheTypedReader) {
  const Topic<Probe> spec{topic("contract/random", keep_all(256))};
  auto reader = TypedReader<Probe>::create(*reading_bus_, spec, notifier_);
  auto raw = open_raw(spec.spec);
  ASSERT_TRUE(reader && raw);
  ASSERT_TRUE(
      eventually([&] { return raw->matched_readers() == 1 && reader->status().matched_writers == 1; }));
  std::uint32_t random = 20260101;  // fixed seed of a linear congruential generator (Numerical Recipes)
  for (int i = 0; i < 200; ++i) {
    Payload bytes = payload(1, 1, 28 + 4 * static_cast<std::size_t>(i));
    for (std::size_t at = 20; at < bytes.size(); ++at) {
      random = random * 1664525U + 1013904223U;
      bytes[at] = static_cast<std::byte>(random >> 24);
    }
    ASSERT_TRUE(raw->write(bytes));
  }
  const Probe good = probe(facts(4));
  ASSERT_TRUE(raw->write(*encode(good)));

  std::vector<Received<Probe>> received;
  ASSERT_TRUE(eventually([&] { return reader->take(received) > 0; }));

  ASSERT_EQ(received.size(), 1U);
  EXPECT_EQ(received[0].value, good);
  EXPECT_EQ(reader->status().malformed, 200U);
  EXPECT_EQ(reader->status().received, 1U);
}

class OtherVersions : public testing::TestWithParam<Vendor> {};
INSTANTIATE_TEST_SUITE_P(Carriers, OtherVersions, testing::Values(Vendor::kFastDds, Vendor::kCycloneDds),
                         carrier_name);

TEST_P(OtherVersions, ANativeTypeOfTheSameNameButOtherMembersIsRefused) {
  const Topic<Probe> spec{topic("contract/versions", keep_all(16, Durability::kTransientLocal))};
  auto bus = open_bus(bus_options(GetParam()));
  auto notifier = std::make_shared<Notifier>();
  auto reader = TypedReader<Probe>::create(*bus, spec, notifier);
  auto impostor = open_impostor(bus_options(Vendor::kCycloneDds, nullptr, "impostor"), spec.spec);
  ASSERT_TRUE(reader && impostor);

  for (std::uint64_t number = 0; number < 5; ++number) ASSERT_TRUE(impostor->write(key_of(1), number));

  std::vector<Received<Probe>> received;
  EXPECT_TRUE(eventually([&] {
    reader->take(received);
    return reader->status().malformed == 5;
  }));
  EXPECT_TRUE(received.empty());
}

}  // namespace
}  // namespace tonus::bus::test
