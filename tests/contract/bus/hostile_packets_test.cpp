#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include "services/bus/refused_packets.hpp"
#include "tests/contract/bus/contract_fixture.hpp"
#include "tests/support/bus/rtps_packet.hpp"

namespace tonus::bus::test {
namespace {

using tonus::test::ChildProcess;
using tonus::test::eventually;
using tonus::test::RtpsPacket;

/// Sends packets to every unicast port of a domain on loopback (RTPS 2.3, 9.6.1.1).
class PacketSender {
 public:
  PacketSender() : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  ~PacketSender() { close(socket_); }
  PacketSender(const PacketSender&) = delete;
  PacketSender& operator=(const PacketSender&) = delete;

  void send(const RtpsPacket::Bytes& bytes) const {
    constexpr int kParticipants = 6;
    for (int participant = 0; participant < kParticipants; ++participant) {
      for (const int offset : {10, 11}) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port =
            htons(static_cast<std::uint16_t>(7400 + 250 * test_domain() + 2 * participant + offset));
        inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
        (void)sendto(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&address),
                     sizeof address);
      }
    }
  }

 private:
  int socket_;
};

class HostilePackets : public testing::TestWithParam<Vendor> {
 protected:
  void SetUp() override {
    bus_ = open_bus(bus_options(GetParam()));
    ASSERT_TRUE(bus_);
    auto reader = bus_->create_reader(topic("peer/gossip", watched_state()), notifier_);
    ASSERT_TRUE(reader);
    reader_ = std::move(*reader);
  }

  /// A state that the other process has sent since.
  [[nodiscard]] bool hears_the_peer() {
    std::vector<Sample> samples;
    (void)reader_->take(samples);
    return eventually([&] {
      samples.clear();
      return reader_->take(samples) > 0;
    });
  }

  std::unique_ptr<Bus> bus_;
  std::shared_ptr<Notifier> notifier_ = std::make_shared<Notifier>();
  std::unique_ptr<Reader> reader_;
  PacketSender sender_;
};
INSTANTIATE_TEST_SUITE_P(Carriers, HostilePackets, testing::Values(Vendor::kFastDds, Vendor::kCycloneDds),
                         carrier_name);

TEST_P(HostilePackets, DoNotEndAProcessThatReceivesThem) {
  ChildProcess peer(
      {TONUS_BUS_PEER, std::string(vendor_name(GetParam())), std::to_string(test_domain()), "gossip", "1"});
  ASSERT_TRUE(hears_the_peer());

  for (int i = 0; i < 10; ++i) {
    sender_.send(tonus::test::statistics_amid_packet().bytes());
    for (const bool is_little_endian : {true, false}) {
      for (const auto& [name, packet] : tonus::test::good_rtps_packets(is_little_endian)) {
        sender_.send(packet.bytes());
        RtpsPacket::Bytes cut = packet.bytes();
        cut.resize(cut.size() - 3);
        sender_.send(cut);
      }
    }
  }

  EXPECT_TRUE(hears_the_peer());
}

TEST_P(HostilePackets, AreCountedWhereTheyAreDropped) {
  if (GetParam() != Vendor::kFastDds) GTEST_SKIP() << "Cyclone DDS does not count them";
  const std::uint64_t before = refused_packets();

  EXPECT_TRUE(eventually([&] {
    sender_.send(tonus::test::statistics_amid_packet().bytes());
    return refused_packets() > before;
  }));
}

class GoodPackets : public BusContract {};
INSTANTIATE_TEST_SUITE_P(Pairs, GoodPackets, kNetworkPairings, pairing_name);

TEST_P(GoodPackets, OfPeersAreNeverRefused) {
  const std::uint64_t refused_before = refused_packets();
  const TopicSpec small = topic("contract/packets", keep_all(64));
  const TopicSpec large = topic("contract/large_packets", keep_all(8), 200'000);  // comes in fragments
  const TopicSpec kept = topic("contract/kept_packets", keep_all(64, Durability::kTransientLocal));
  auto small_writer = make_writer(small);
  auto large_writer = make_writer(large);
  auto kept_writer = make_writer(kept);
  for (std::uint64_t number = 0; number < 30; ++number)
    ASSERT_TRUE(kept_writer->write(payload(static_cast<std::uint8_t>(number % 3), number)));
  auto small_reader = make_reader(small);
  auto large_reader = make_reader(large);
  auto kept_reader = make_reader(kept);
  ASSERT_TRUE(are_matched(*small_writer, *small_reader));
  ASSERT_TRUE(are_matched(*large_writer, *large_reader));

  for (std::uint64_t number = 0; number < 30; ++number) ASSERT_TRUE(small_writer->write(payload(1, number)));
  for (std::uint64_t number = 0; number < 4; ++number)
    ASSERT_TRUE(large_writer->write(payload(1, number, 150'000)));

  EXPECT_EQ(receive(*small_reader, *notifier_, 30).size(), 30U);
  EXPECT_EQ(receive(*large_reader, *notifier_, 4).size(), 4U);
  EXPECT_EQ(receive(*kept_reader, *notifier_, 30).size(), 30U);
  EXPECT_EQ(refused_packets(), refused_before);
}

}  // namespace
}  // namespace tonus::bus::test
