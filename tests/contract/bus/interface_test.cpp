#include <thread>

#include "tests/contract/bus/contract_fixture.hpp"

namespace tonus::bus::test {
namespace {

class BusInterface : public BusContract {};
INSTANTIATE_TEST_SUITE_P(Pairs, BusInterface, kAllPairings, pairing_name);

TEST_P(BusInterface, RefusesToWriteMalformedPayloads) {
  const TopicSpec spec = topic("contract/refused", keep_all(8), 128);
  auto writer = make_writer(spec);
  Payload wrong_encapsulation = payload(1, 1);
  wrong_encapsulation[1] = std::byte{3};

  for (const Payload& bad : {Payload{}, Payload(19, std::byte{0}), wrong_encapsulation, payload(1, 1, 132)}) {
    const auto written = writer->write(bad);
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().code, ErrorCode::kInvalidArgument);
  }
  EXPECT_TRUE(writer->write(payload(1, 1, 128)));
  EXPECT_EQ(writer->status().refused, 4U);
  EXPECT_EQ(writer->status().written, 1U);
}

TEST_P(BusInterface, RefusesTopicsThatCannotBeKept) {
  TopicSpec nameless = topic("", state());
  TopicSpec bottomless = topic("contract/deep", keep_all(1000000));
  TopicSpec too_small = topic("contract/small", state(), 19);
  for (const TopicSpec& spec : {nameless, bottomless, too_small}) {
    EXPECT_EQ(writing_bus_->create_writer(spec).error().code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(reading_bus_->create_reader(spec, nullptr).error().code, ErrorCode::kInvalidArgument);
  }
  EXPECT_EQ(writing_bus_->create_writer(bottomless).error().message,
            "topic 'contract/deep': depth: 1000000 is not allowed; expected 1 to 4096");
}

TEST_P(BusInterface, OneBusWritesAndReadsTheSameTopic) {
  const TopicSpec spec = topic("contract/own", keep_all(8));
  auto writer = reading_bus_->create_writer(spec);
  auto reader = make_reader(spec);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(are_matched(**writer, *reader));

  ASSERT_TRUE((*writer)->write(payload(1, 12)));

  EXPECT_EQ(numbers_of(receive(*reader, *notifier_, 1)), (std::vector<std::uint64_t>{12}));
}

TEST_P(BusInterface, SignalsTheNotifierWhenAWriterComesAndGoes) {
  const TopicSpec spec = topic("contract/signals", state());
  auto reader = make_reader(spec);
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds{20};
  auto writer = make_writer(spec);
  while (reader->status().matched_writers == 0) ASSERT_TRUE(notifier_->wait_until(limit));

  writer.reset();

  while (reader->status().matched_writers == 1) ASSERT_TRUE(notifier_->wait_until(limit));
}

TEST(BusOptionsCheck, NamesWhatIsWrong) {
  BusOptions options;
  options.domain = 233;
  EXPECT_EQ(create_bus(options).error().message, "domain: 233 is not allowed; expected 0 to 232");
  options = {};
  options.network.interface_address = "lo";
  EXPECT_EQ(create_bus(options).error().message,
            "interface address: 'lo' is not allowed; expected an IPv4 address such as 127.0.0.1");
  options = {};
  options.network.peers = {"127.0.0.1", "rig\"/>"};
  EXPECT_EQ(create_bus(options).error().message,
            "peer: 'rig\"/>' is not allowed; expected an IPv4 address such as 127.0.0.1");
  options = {};
  options.vendor = Vendor::kMemory;
  EXPECT_EQ(create_bus(options).error().code, ErrorCode::kInvalidArgument);
}

TEST(BusOptionsCheck, AnAddressThatIsNotThisMachinesIsUnavailable) {
  for (const Vendor vendor : {Vendor::kFastDds, Vendor::kCycloneDds}) {
    BusOptions options = bus_options(vendor);
    options.network.interface_address = "192.0.2.77";  // TEST-NET-1, RFC 5737: nobody's
    const auto bus = create_bus(options);
    ASSERT_FALSE(bus) << vendor_name(vendor);
    EXPECT_EQ(bus.error().code, ErrorCode::kUnavailable);
    EXPECT_NE(bus.error().message.find("192.0.2.77"), std::string::npos);
  }
}

TEST(VendorNames, AreReadAndRefused) {
  EXPECT_EQ(*parse_vendor("fastdds"), Vendor::kFastDds);
  EXPECT_EQ(*parse_vendor("cyclonedds"), Vendor::kCycloneDds);
  EXPECT_EQ(*parse_vendor("memory"), Vendor::kMemory);
  EXPECT_EQ(parse_vendor("Fast").error().message,
            "DDS vendor: 'Fast' is not allowed; expected fastdds, cyclonedds or memory");
}

TEST(NotifierWait, KeepsASignalGivenBeforeAndReportsNone) {
  Notifier notifier;
  EXPECT_FALSE(notifier.wait_until(std::chrono::steady_clock::now()));
  notifier.notify();
  notifier.notify();
  EXPECT_TRUE(notifier.wait_until(std::chrono::steady_clock::now()));
  EXPECT_FALSE(notifier.wait_until(std::chrono::steady_clock::now()));
}

TEST(NotifierWait, LosesNoSignalOfAnotherThread) {
  Notifier there;
  Notifier back;
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds{30};
  std::thread other([&] {
    for (int i = 0; i < 2000 && there.wait_until(limit); ++i) back.notify();
  });
  int answers = 0;
  for (; answers < 2000; ++answers) {
    there.notify();
    if (!back.wait_until(limit)) break;
  }
  other.join();
  EXPECT_EQ(answers, 2000);
}

}  // namespace
}  // namespace tonus::bus::test
