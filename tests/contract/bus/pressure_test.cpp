#include <csignal>
#include <cstdlib>

#include "tests/contract/bus/contract_fixture.hpp"

namespace tonus::bus::test {
namespace {

using tonus::test::ChildProcess;
using tonus::test::eventually;

class BusUnderPressure : public BusContract {};
INSTANTIATE_TEST_SUITE_P(Pairs, BusUnderPressure, kAllPairings, pairing_name);

class BusWithAPeer : public BusContract {
 protected:
  [[nodiscard]] static std::vector<std::string> peer(Vendor vendor, const std::string& mode, int number) {
    return {TONUS_BUS_PEER, std::string(vendor_name(vendor)), std::to_string(test_domain()), mode,
            std::to_string(number)};
  }
};
INSTANTIATE_TEST_SUITE_P(Pairs, BusWithAPeer, kNetworkPairings, pairing_name);

/// Writes numbers from `first` on until one is refused for want of room; how many were accepted.
std::uint64_t write_until_full(Writer& writer, std::uint64_t first, std::uint64_t limit) {
  for (std::uint64_t number = first; number < limit; ++number) {
    const auto written = writer.write(payload(1, number));
    if (written) continue;
    EXPECT_EQ(written.error().code, ErrorCode::kTimeout) << written.error().message;
    return number - first;
  }
  return limit - first;
}

TEST_P(BusUnderPressure, ReportsWhatAStoppedReaderLeavesNoRoomForAndLosesNothing) {
  const TopicSpec spec = topic("contract/pressure", keep_all(16));
  auto reader = make_reader(spec);
  auto writer = make_writer(spec);
  ASSERT_TRUE(are_matched(*writer, *reader));

  const std::uint64_t accepted = write_until_full(*writer, 0, 1000);

  ASSERT_GE(accepted, 16U);
  ASSERT_LT(accepted, 1000U);
  EXPECT_EQ(writer->status().written, accepted);
  EXPECT_EQ(writer->status().refused, 1U);

  std::vector<Sample> received = receive(*reader, *notifier_, accepted);
  std::uint64_t number = accepted;
  for (; number < accepted + 100; ++number) {  // what was refused is tried again, and goes on
    ASSERT_TRUE(eventually([&] {
      reader->take(received);
      return writer->write(payload(1, number)).has_value();
    }));
  }
  for (Sample& sample : receive(*reader, *notifier_, number - received.size()))
    received.push_back(std::move(sample));
  std::vector<std::uint64_t> sent(number);
  for (std::uint64_t i = 0; i < number; ++i) sent[i] = i;
  EXPECT_EQ(numbers_of(received), sent);
  EXPECT_EQ(reader->status().lost, 0U);
}

TEST_P(BusUnderPressure, WriterOfManyKeysGoesOnAfterItsHistoryWasFilledManyTimes) {
  const TopicSpec spec = topic("contract/many_keys", keep_all(16));
  auto reader = make_reader(spec);
  auto writer = make_writer(spec);
  ASSERT_TRUE(are_matched(*writer, *reader));
  std::vector<Sample> received;
  std::vector<std::uint64_t> sent;

  for (std::uint64_t number = 0; number < 250; ++number) {  // 250 keys of one sample: far more than 16
    ASSERT_TRUE(eventually([&] {
      reader->take(received);
      return writer->write(payload(static_cast<std::uint8_t>(number), number)).has_value();
    }));
    sent.push_back(number);
  }

  for (Sample& sample : receive(*reader, *notifier_, 250 - received.size()))
    received.push_back(std::move(sample));
  EXPECT_EQ(numbers_of(received), sent);
}

TEST_P(BusUnderPressure, AFullReaderDoesNotHoldUpTheStatesOfItsProcess) {
  const TopicSpec bulk = topic("contract/pressure", keep_all(16));
  const TopicSpec watched = topic("contract/watched", watched_state());
  auto bulk_reader = make_reader(bulk);
  auto bulk_writer = make_writer(bulk);
  auto state_reader = make_reader(watched);
  auto state_writer = make_writer(watched);
  ASSERT_TRUE(are_matched(*bulk_writer, *bulk_reader));
  ASSERT_TRUE(are_matched(*state_writer, *state_reader));
  ASSERT_LT(write_until_full(*bulk_writer, 0, 1000), 1000U);

  ASSERT_TRUE(state_writer->write(payload(1, 5)));

  std::vector<Sample> received;
  EXPECT_TRUE(eventually([&] { return state_reader->take(received) == 1; }));
  EXPECT_EQ(write_until_full(*bulk_writer, 2000, 2010), 0U);  // still full
  EXPECT_EQ(state_reader->status().liveliness_lost_events, 0U);
}

TEST_P(BusUnderPressure, ReportsMissedDeadlinesToBothSides) {
  Qos qos = state();
  qos.deadline = std::chrono::milliseconds{60};
  const TopicSpec spec = topic("contract/deadline", qos);
  auto reader = make_reader(spec);
  auto writer = make_writer(spec);
  ASSERT_TRUE(are_matched(*writer, *reader));

  ASSERT_TRUE(writer->write(payload(1, 1)));

  EXPECT_TRUE(eventually([&] { return reader->status().deadline_missed >= 2; }));
  EXPECT_TRUE(eventually([&] { return writer->status().deadline_missed >= 2; }));
}

TEST_P(BusWithAPeer, LosesNothingToAStoppedReadingProcess) {
  const TopicSpec spec = topic("peer/samples", keep_all(16));
  ChildProcess child(peer(GetParam().reader, "read", 16));
  ASSERT_TRUE(child.is_running());
  auto writer = make_writer(spec);
  ASSERT_TRUE(eventually([&] { return writer->status().matched_readers == 1; }));
  ASSERT_TRUE(eventually([&] {  // the child has matched too once it reports a number
    static_cast<void>(writer->write(payload(1, 1000000)));
    return !child.take_lines().empty();
  }));
  ASSERT_TRUE(writer->wait_acknowledged(std::chrono::seconds{20}));

  child.send_signal(SIGSTOP);
  const std::uint64_t accepted = write_until_full(*writer, 0, 5000);
  child.send_signal(SIGCONT);

  ASSERT_LT(accepted, 5000U);
  std::uint64_t number = accepted;
  for (; number < accepted + 50; ++number) {
    ASSERT_TRUE(eventually([&] { return writer->write(payload(1, number)).has_value(); }));
  }
  std::vector<std::uint64_t> received;
  ASSERT_TRUE(eventually([&] {
    for (const std::string& line : child.take_lines()) {
      if (line != "1000000") received.push_back(std::stoull(line));
    }
    return received.size() >= number;
  })) << received.size()
      << " of " << number;
  std::vector<std::uint64_t> sent(number);
  for (std::uint64_t i = 0; i < number; ++i) sent[i] = i;
  EXPECT_EQ(received, sent);
}

TEST_P(BusWithAPeer, ReportsAKilledWriterAndMatchesItsSuccessor) {
  const TopicSpec spec = topic("peer/state", watched_state());
  auto reader = make_reader(spec);
  std::vector<Sample> received;
  {
    ChildProcess first(peer(GetParam().writer, "write", 0));
    ASSERT_TRUE(first.is_running());
    ASSERT_TRUE(
        eventually([&] { return reader->take(received) > 0 && reader->status().alive_writers == 1; }));
    first.kill();
  }
  ASSERT_TRUE(eventually([&] { return reader->status().liveliness_lost_events == 1; }));
  EXPECT_EQ(reader->status().alive_writers, 0);
  received.clear();

  ChildProcess second(peer(GetParam().writer, "write", 5000));

  ASSERT_TRUE(eventually([&] {
    reader->take(received);
    return !received.empty() && number_in(*received.back().payload) >= 5000;
  }));
  // The dead one's place is given up when its lease is over; then the new one is alone.
  EXPECT_TRUE(eventually(
      [&] { return reader->status().matched_writers == 1 && reader->status().alive_writers == 1; }));
}

TEST(MemoryBusFaults, AKilledWriterIsReportedAndItsSuccessorMatched) {
  auto fabric = std::make_shared<MemoryFabric>();
  auto notifier = std::make_shared<Notifier>();
  auto reading = open_bus(bus_options(Vendor::kMemory, fabric, "reading"));
  BusOptions options = bus_options(Vendor::kMemory, fabric, "victim");
  options.participant_lease = std::chrono::milliseconds{600};
  auto writing = open_bus(options);
  const TopicSpec spec = topic("peer/state", watched_state());
  auto reader = reading->create_reader(spec, notifier);
  auto writer = writing->create_writer(spec);
  ASSERT_TRUE(reader && writer);
  ASSERT_EQ((*reader)->status().alive_writers, 1);

  fabric->kill("victim");

  ASSERT_TRUE(eventually([&] { return (*reader)->status().liveliness_lost_events == 1; }));
  EXPECT_EQ((*reader)->status().alive_writers, 0);
  EXPECT_TRUE(eventually([&] { return (*reader)->status().matched_writers == 0; }));
  auto successor = open_bus(bus_options(Vendor::kMemory, fabric, "successor"))->create_writer(spec);
  ASSERT_TRUE(successor);
  ASSERT_TRUE((*successor)->write(payload(1, 3)));
  EXPECT_EQ(numbers_of(receive(**reader, *notifier, 1)), (std::vector<std::uint64_t>{3}));
  EXPECT_EQ((*reader)->status().alive_writers, 1);
}

TEST(MemoryBusFaults, AKilledReaderHoldsItsWriterUpUntilItsLeaseIsOver) {
  auto fabric = std::make_shared<MemoryFabric>();
  auto writing = open_bus(bus_options(Vendor::kMemory, fabric, "writing"));
  BusOptions options = bus_options(Vendor::kMemory, fabric, "victim");
  options.participant_lease = std::chrono::milliseconds{500};
  auto reading = open_bus(options);
  const TopicSpec spec = topic("contract/samples", keep_all(4));
  auto reader = reading->create_reader(spec, nullptr);
  auto writer = writing->create_writer(spec);
  ASSERT_TRUE(reader && writer);

  fabric->kill("victim");

  EXPECT_FALSE((*writer)->wait_acknowledged(std::chrono::milliseconds{1}));
  EXPECT_TRUE((*writer)->wait_acknowledged(std::chrono::seconds{20}));
  EXPECT_EQ((*writer)->status().matched_readers, 0);
}

}  // namespace
}  // namespace tonus::bus::test
