#include <algorithm>

#include "tests/contract/bus/contract_fixture.hpp"

namespace tonus::bus::test {
namespace {

using tonus::test::eventually;

INSTANTIATE_TEST_SUITE_P(Pairs, BusContract, kAllPairings, pairing_name);

std::int64_t nanoseconds(auto time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

TEST_P(BusContract, DeliversPayloadsOfManyKeysUnchangedAndInOrder) {
  const TopicSpec spec = topic("contract/samples", keep_all(64));
  auto reader = make_reader(spec);
  auto writer = make_writer(spec);
  ASSERT_TRUE(are_matched(*writer, *reader));
  std::vector<Payload> sent;
  std::vector<Sample> received;
  for (std::uint64_t number = 0; number < 400; ++number) {
    sent.push_back(payload(static_cast<std::uint8_t>(number % 7), number, 28 + 4 * (number % 100)));
    while (!writer->write(sent.back())) reader->take(received);
    reader->take(received);
  }

  for (Sample& sample : receive(*reader, *notifier_, sent.size() - received.size())) {
    received.push_back(std::move(sample));
  }

  ASSERT_EQ(received.size(), sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    ASSERT_EQ(*received[i].payload, sent[i]) << i;
    ASSERT_EQ(received[i].key, key_of(static_cast<std::uint8_t>(i % 7))) << i;
  }
  EXPECT_EQ(writer->status().written, sent.size());
  EXPECT_EQ(reader->status().received, sent.size());
  EXPECT_EQ(reader->status().malformed, 0U);
  EXPECT_EQ(reader->status().lost, 0U);
}

TEST_P(BusContract, PadsPayloadsToAMultipleOfFour) {
  const TopicSpec spec = topic("contract/padding", keep_all(8));
  auto reader = make_reader(spec);
  auto writer = make_writer(spec);
  ASSERT_TRUE(are_matched(*writer, *reader));

  ASSERT_TRUE(writer->write(payload(1, 5, 29)));

  const auto received = receive(*reader, *notifier_, 1);
  ASSERT_EQ(received.size(), 1U);
  EXPECT_EQ(*received[0].payload, payload(1, 5, 32));
}

TEST_P(BusContract, StampsWritingAndReception) {
  const TopicSpec spec = topic("contract/stamps", keep_all(8));
  auto reader = make_reader(spec);
  auto writer = make_writer(spec);
  ASSERT_TRUE(are_matched(*writer, *reader));
  constexpr std::int64_t kRounding =
      1000000;  // RTPS stamps are fractions of 2^32; Fast DDS's reception is converted
  const std::int64_t system_before = nanoseconds(std::chrono::system_clock::now());
  const std::int64_t steady_before = nanoseconds(std::chrono::steady_clock::now());

  ASSERT_TRUE(writer->write(payload(1, 1)));
  const auto received = receive(*reader, *notifier_, 1);

  ASSERT_EQ(received.size(), 1U);
  EXPECT_GE(received[0].source_timestamp_ns, system_before - kRounding);
  EXPECT_LE(received[0].source_timestamp_ns, nanoseconds(std::chrono::system_clock::now()) + kRounding);
  EXPECT_GE(received[0].received_ns, steady_before - kRounding);
  EXPECT_LE(received[0].received_ns, nanoseconds(std::chrono::steady_clock::now()) + kRounding);
}

TEST_P(BusContract, CarriesPayloadsOfAMegabyte) {
  constexpr std::size_t kBytes = 1 << 20;
  const TopicSpec spec = topic("contract/large", keep_all(4), kBytes);
  auto reader = make_reader(spec);
  auto writer = make_writer(spec);
  ASSERT_TRUE(are_matched(*writer, *reader));
  Payload large = payload(3, 9, kBytes);
  for (std::size_t i = 28; i < large.size(); ++i) large[i] = static_cast<std::byte>(i * 2654435761U >> 24);

  ASSERT_TRUE(writer->write(large));

  const auto received = receive(*reader, *notifier_, 1);
  ASSERT_EQ(received.size(), 1U);
  EXPECT_TRUE(*received[0].payload == large);
}

TEST_P(BusContract, KeepsTheLastSampleOfEachKeyForAReaderThatDoesNotTake) {
  Qos qos = state();
  qos.durability = Durability::kVolatile;
  const TopicSpec spec = topic("contract/state", qos);
  auto reader = make_reader(spec);
  auto writer = make_writer(spec);
  ASSERT_TRUE(are_matched(*writer, *reader));

  for (std::uint64_t number = 0; number < 50; ++number) {
    ASSERT_TRUE(writer->write(payload(static_cast<std::uint8_t>(number % 5), number)));
  }
  ASSERT_TRUE(writer->wait_acknowledged(std::chrono::seconds{20}));

  std::vector<Sample> received;
  ASSERT_TRUE(eventually([&] {
    reader->take(received);
    return !received.empty() && number_in(*received.back().payload) == 49;
  }));
  EXPECT_EQ(numbers_of(received), (std::vector<std::uint64_t>{45, 46, 47, 48, 49}));
}

TEST_P(BusContract, GivesALateReaderTheLastStateOfEachKey) {
  const TopicSpec spec = topic("contract/state", state());
  auto writer = make_writer(spec);
  for (std::uint64_t number = 0; number < 30; ++number) {
    ASSERT_TRUE(writer->write(payload(static_cast<std::uint8_t>(number % 3), number)));
  }

  auto reader = make_reader(spec);

  const auto received = receive(*reader, *notifier_, 3);
  EXPECT_EQ(numbers_of(received), (std::vector<std::uint64_t>{27, 28, 29}));
}

TEST_P(BusContract, GivesALateReaderTheWholeHistoryOfAKeepAllTopic) {
  const TopicSpec spec = topic("contract/results", keep_all(100, Durability::kTransientLocal));
  auto writer = make_writer(spec);
  std::vector<std::uint64_t> sent;
  for (std::uint64_t number = 0; number < 100; ++number) {
    ASSERT_TRUE(writer->write(payload(static_cast<std::uint8_t>(number), number)));
    sent.push_back(number);
  }

  auto reader = make_reader(spec);

  EXPECT_EQ(numbers_of(receive(*reader, *notifier_, 100)), sent);
}

TEST_P(BusContract, GivesALateReaderNothingOfAVolatileTopic) {
  const TopicSpec spec = topic("contract/volatile", keep_all(16));
  auto writer = make_writer(spec);
  ASSERT_TRUE(writer->write(payload(1, 1)));
  auto reader = make_reader(spec);
  ASSERT_TRUE(are_matched(*writer, *reader));

  ASSERT_TRUE(writer->write(payload(1, 2)));

  EXPECT_EQ(numbers_of(receive(*reader, *notifier_, 1)), (std::vector<std::uint64_t>{2}));
}

TEST_P(BusContract, DeliversFromTheFirstSampleThatAMatchedWriterAccepts) {
  const TopicSpec spec = topic("contract/first", keep_all(64));
  auto writer = make_writer(spec);
  auto reader = make_reader(spec);
  std::vector<std::uint64_t> sent;
  // The reader may not know the writer yet: discovery ends at different times on the two sides.
  ASSERT_TRUE(eventually([&] { return writer->status().matched_readers == 1; }));

  for (std::uint64_t number = 0; number < 20; ++number) {
    ASSERT_TRUE(eventually([&] { return writer->write(payload(1, number)).has_value(); }));
    sent.push_back(number);
  }

  EXPECT_EQ(numbers_of(receive(*reader, *notifier_, sent.size())), sent);
}

TEST_P(BusContract, TakesNoMoreThanAskedForAndKeepsTheRest) {
  const TopicSpec spec = topic("contract/portions", keep_all(16));
  auto reader = make_reader(spec);
  auto writer = make_writer(spec);
  ASSERT_TRUE(are_matched(*writer, *reader));
  for (std::uint64_t number = 0; number < 10; ++number) ASSERT_TRUE(writer->write(payload(1, number)));
  ASSERT_TRUE(writer->wait_acknowledged(std::chrono::seconds{20}));

  std::vector<Sample> received;
  ASSERT_TRUE(eventually([&] { return reader->take(received, 3) == 3; }));
  EXPECT_EQ(received.size(), 3U);

  ASSERT_TRUE(eventually([&] {
    reader->take(received, 4);
    return received.size() == 10;
  }));
  EXPECT_EQ(numbers_of(received), (std::vector<std::uint64_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
}

TEST_P(BusContract, WritersAndReadersOutliveTheirBus) {
  const TopicSpec spec = topic("contract/outlive", keep_all(8));
  auto reader = make_reader(spec);
  auto writer = make_writer(spec);
  writing_bus_.reset();
  reading_bus_.reset();
  ASSERT_TRUE(are_matched(*writer, *reader));

  ASSERT_TRUE(writer->write(payload(1, 77)));

  EXPECT_EQ(numbers_of(receive(*reader, *notifier_, 1)), (std::vector<std::uint64_t>{77}));
}

TEST_P(BusContract, SeesAWriterLeaveWithoutCallingItDead) {
  const TopicSpec spec = topic("contract/leaving", watched_state());
  auto reader = make_reader(spec);
  auto writer = make_writer(spec);
  ASSERT_TRUE(are_matched(*writer, *reader));
  ASSERT_TRUE(writer->write(payload(1, 1)));
  ASSERT_TRUE(eventually([&] { return reader->status().alive_writers == 1; }));

  writer.reset();

  ASSERT_TRUE(eventually([&] { return reader->status().matched_writers == 0; }));
  EXPECT_EQ(reader->status().alive_writers, 0);
  EXPECT_EQ(reader->status().liveliness_lost_events, 0U);
}

TEST_P(BusContract, AReaderThatComesLaterSilencesNoneOfTheOthers) {
  const TopicSpec spec = topic("contract/third", keep_all(64));
  auto writer = make_writer(spec);
  const auto own_kind = open_bus(bus_options(GetParam().writer, fabric_, "third"));
  auto first = own_kind->create_reader(spec, notifier_);
  ASSERT_TRUE(first);
  ASSERT_TRUE(eventually([&] { return writer->status().matched_readers == 1; }));
  auto later = make_reader(spec);
  ASSERT_TRUE(eventually([&] { return writer->status().matched_readers == 2; }));
  ASSERT_TRUE(eventually([&] { return later->status().matched_writers == 1; }));

  for (std::uint64_t number = 0; number < 20; ++number) {
    ASSERT_TRUE(eventually([&] { return writer->write(payload(1, number)).has_value(); })) << number;
  }

  EXPECT_EQ(receive(**first, *notifier_, 20).size(), 20U);
  EXPECT_EQ(receive(*later, *notifier_, 20).size(), 20U);
}

}  // namespace
}  // namespace tonus::bus::test
