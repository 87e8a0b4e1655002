#include <arpa/inet.h>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <map>
#include <sstream>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/contract/bus/contract_fixture.hpp"
#include "tests/support/bus/private_network.hpp"

namespace tonus::bus::test {
namespace {

using tonus::test::eventually;
using tonus::test::is_in_private_network;
using tonus::test::run_program;

constexpr const char* kNotPermitted =
    "needs a network namespace of its own, which this system does not permit";

class BusOnABadNetwork : public BusContract {};
INSTANTIATE_TEST_SUITE_P(Pairs, BusOnABadNetwork, kNetworkPairings, pairing_name);

/// Packets that the rule has dropped, from nft's own counter.
Result<long> dropped_packets(const std::string& file) {
  if (auto listed = run_program({"sh", "-c", "nft list table inet loss > " + file}); !listed)
    return listed.error();
  std::ifstream in(file);
  for (std::string word; in >> word;) {
    long count = 0;
    if (word == "packets" && in >> count) return count;
  }
  return fail(ErrorCode::kNotFound, "no counter in nft's answer");
}

TEST_P(BusOnABadNetwork, LosesNothingAtFivePercentPacketLoss) {
  if (!is_in_private_network()) GTEST_SKIP() << kNotPermitted;
  const bool is_filtered =
      run_program({"nft", "add table inet loss"}) &&
      run_program({"nft", "add chain inet loss input { type filter hook input priority 0; }"}) &&
      run_program(
          {"nft", "add rule inet loss input meta l4proto udp numgen random mod 100 < 5 counter drop"});
  if (!is_filtered) GTEST_SKIP() << "needs nft (package nftables) and its kernel modules";
  const TopicSpec spec = topic("contract/lossy", keep_all(64));
  auto reader = make_reader(spec);
  auto writer = make_writer(spec);
  ASSERT_TRUE(are_matched(*writer, *reader));
  std::vector<Sample> received;
  std::vector<std::uint64_t> sent;

  for (std::uint64_t number = 0; number < 1000; ++number) {
    ASSERT_TRUE(eventually([&] {
      reader->take(received);
      return writer->write(payload(1, number, 200)).has_value();
    }));
    sent.push_back(number);
  }
  for (Sample& sample : receive(*reader, *notifier_, sent.size() - received.size())) {
    received.push_back(std::move(sample));
  }

  EXPECT_EQ(numbers_of(received), sent);
  const std::string file = testing::TempDir() + "tonus_loss_" + std::to_string(getpid());
  const auto dropped = dropped_packets(file);
  std::remove(file.c_str());
  ASSERT_TRUE(dropped) << dropped.error().message;
  EXPECT_GT(*dropped, 0);
  RecordProperty("dropped_packets", static_cast<int>(*dropped));
  ASSERT_TRUE(run_program({"nft", "delete table inet loss"}));
}

/// Packets sent by an interface since it was made (the transmit column of /proc/net/dev).
long sent_packets(const std::string& interface) {
  std::ifstream in("/proc/self/net/dev");
  for (std::string line; std::getline(in, line);) {
    const auto colon = line.find(':');
    const auto start = line.find_first_not_of(' ');
    if (colon == std::string::npos || line.substr(start, colon - start) != interface) continue;
    std::istringstream columns(line.substr(colon + 1));
    long value = 0;
    for (int column = 0; column < 10; ++column) columns >> value;
    return value;
  }
  return -1;
}

/// Multicast groups (IPv4) that sockets of this network have joined, besides 224.0.0.1, which every interface
/// is in.
long joined_groups() {
  std::ifstream in("/proc/self/net/igmp");
  long count = 0;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string group;
    words >> group;
    const bool is_group = line.starts_with("\t") && group.size() == 8;
    count += is_group && group != "010000E0" ? 1 : 0;
  }
  return count;
}

/// Joins 239.255.0.1 on the decoy, as a participant on multicast would; the socket.
int join_discovery_group() {
  const int socket_fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ip_mreq request{};
  inet_pton(AF_INET, "239.255.0.1", &request.imr_multiaddr);
  inet_pton(AF_INET, "10.99.0.1", &request.imr_interface);
  setsockopt(socket_fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request);
  return socket_fd;
}

/// Sends one packet to a host behind the decoy.
void send_probe_packet() {
  const int socket_fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(9);
  inet_pton(AF_INET, "10.99.0.2", &address.sin_addr);
  static_cast<void>(
      sendto(socket_fd, "x", 1, 0, reinterpret_cast<const sockaddr*>(&address), sizeof address));
  close(socket_fd);
}

class BusConfined : public testing::TestWithParam<Vendor> {};
INSTANTIATE_TEST_SUITE_P(Carriers, BusConfined, testing::Values(Vendor::kFastDds, Vendor::kCycloneDds),
                         carrier_name);

/// The bait: an interface that is up, can multicast, and has the default route; its address is 10.99.0.1.
bool make_decoy() {
  return run_program({"ip", "link", "add", "decoy", "type", "veth", "peer", "name", "decoyend"}) &&
         run_program({"ip", "addr", "add", "10.99.0.1/24", "dev", "decoy"}) &&
         run_program({"ip", "link", "set", "decoyend", "up"}) &&
         run_program({"ip", "link", "set", "decoy", "up", "multicast", "on"}) &&
         run_program({"ip", "neigh", "add", "10.99.0.2", "lladdr", "02:00:00:00:00:02", "dev", "decoy", "nud",
                      "permanent"}) &&
         run_program({"ip", "route", "add", "default", "via", "10.99.0.2"});
}

TEST_P(BusConfined, NoPacketLeavesTheLoopbackInterface) {
  if (!is_in_private_network()) GTEST_SKIP() << kNotPermitted;
  if (!make_decoy()) GTEST_SKIP() << "needs ip (package iproute2) and veth interfaces";
  std::ofstream("/proc/sys/net/ipv6/conf/decoy/disable_ipv6") << 1;  // its own chatter; there may be no IPv6
  const long before = sent_packets("decoy");
  ASSERT_GE(before, 0);

  {
    const TopicSpec spec = topic("contract/confined", keep_all(16));
    auto notifier = std::make_shared<Notifier>();
    auto one = open_bus(bus_options(GetParam()));
    auto other = open_bus(bus_options(GetParam()));
    auto writer = one->create_writer(spec);
    auto reader = other->create_reader(spec, notifier);
    ASSERT_TRUE(writer && reader);
    ASSERT_TRUE(are_matched(**writer, **reader));
    for (std::uint64_t number = 0; number < 10; ++number) ASSERT_TRUE((*writer)->write(payload(1, number)));
    ASSERT_EQ(receive(**reader, *notifier, 10).size(), 10U);
    ASSERT_GT(sent_packets("lo"), 10);
    EXPECT_EQ(joined_groups(), 0);
  }  // the goodbyes are sent here

  EXPECT_EQ(sent_packets("decoy"), before);
  send_probe_packet();
  EXPECT_EQ(sent_packets("decoy"), before + 1);  // the counts do count
  const int joined = join_discovery_group();
  EXPECT_EQ(joined_groups(), 1);
  close(joined);
  EXPECT_TRUE(run_program({"ip", "link", "delete", "decoy"}));
}

/// Packets that the kernel has dropped at sockets instead of queueing them (/proc/net/udp, last column).
long packets_dropped_at_sockets() {
  std::ifstream in("/proc/self/net/udp");
  long sum = 0;
  std::string line;
  std::getline(in, line);  // the heads of the columns
  while (std::getline(in, line)) {
    const auto last = line.find_last_not_of(' ');
    sum += std::stol(line.substr(line.find_last_of(' ', last)));
  }
  return sum;
}

/// The other participants are on the decoy's address and look for peers there, in the same domain.
TEST_P(BusConfined, PacketsForAnotherAddressOfThisMachineAreNotTaken) {
  if (!is_in_private_network()) GTEST_SKIP() << kNotPermitted;
  if (!make_decoy()) GTEST_SKIP() << "needs ip (package iproute2) and veth interfaces";
  const TopicSpec spec = topic("contract/foreign", state());
  {
    auto confined = open_bus(bus_options(GetParam()));
    auto confined_reader = confined->create_reader(spec, nullptr);
    const long dropped_before = packets_dropped_at_sockets();
    BusOptions options = bus_options(Vendor::kCycloneDds);
    options.network.interface_address = "10.99.0.1";
    options.network.peers = {"10.99.0.1"};
    auto foreign = open_bus(options);
    auto other = open_bus(options);
    auto foreign_writer = foreign->create_writer(spec);
    auto other_reader = other->create_reader(spec, nullptr);
    ASSERT_TRUE(confined_reader && foreign_writer && other_reader);

    ASSERT_TRUE(are_matched(**foreign_writer, **other_reader));
    if (GetParam() == Vendor::kCycloneDds) {  // Fast DDS is bound to its address: packets arrive nowhere
      ASSERT_TRUE(eventually([&] { return packets_dropped_at_sockets() > dropped_before + 5; }));
    }

    EXPECT_EQ((*confined_reader)->status().matched_writers, 0);
    EXPECT_EQ((*foreign_writer)->status().matched_readers, 1);
  }
  EXPECT_TRUE(run_program({"ip", "link", "delete", "decoy"}));
}

/// Five of each vendor.
TEST(BusRoster, TenParticipantsAtOnceFindEachOtherCompletely) {
  const TopicSpec spec = topic("contract/roster", state());
  constexpr int kCount = 10;
  std::vector<std::unique_ptr<Bus>> buses;
  std::vector<std::unique_ptr<Writer>> writers;
  std::vector<std::unique_ptr<Reader>> readers;
  for (int i = 0; i < kCount; ++i) {
    buses.push_back(open_bus(bus_options(i % 2 == 0 ? Vendor::kFastDds : Vendor::kCycloneDds)));
    auto writer = buses.back()->create_writer(spec);
    auto reader = buses.back()->create_reader(spec, nullptr);
    ASSERT_TRUE(writer && reader);
    writers.push_back(std::move(*writer));
    readers.push_back(std::move(*reader));
    ASSERT_TRUE(writers.back()->write(payload(static_cast<std::uint8_t>(i), static_cast<std::uint64_t>(i))));
  }

  std::vector<std::map<Key, std::uint64_t>> seen(kCount);
  EXPECT_TRUE(eventually([&] {
    bool is_complete = true;
    for (std::size_t i = 0; i < kCount; ++i) {
      std::vector<Sample> samples;
      readers[i]->take(samples);
      for (const Sample& sample : samples) seen[i][sample.key] = number_in(*sample.payload);
      is_complete = is_complete && seen[i].size() == kCount &&
                    readers[i]->status().matched_writers == kCount &&
                    writers[i]->status().matched_readers == kCount;
    }
    return is_complete;
  }));
}

class BusTurnover : public testing::TestWithParam<Vendor> {};
INSTANTIATE_TEST_SUITE_P(Carriers, BusTurnover, testing::Values(Vendor::kFastDds, Vendor::kCycloneDds),
                         carrier_name);

TEST_P(BusTurnover, ParticipantsAreFoundAfterAHundredOfTheirProcessHaveComeAndGone) {
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(open_bus(bus_options(GetParam())));
  const TopicSpec spec = topic("contract/turnover", state());
  auto one = open_bus(bus_options(GetParam()));
  auto other = open_bus(bus_options(GetParam()));
  auto writer = one->create_writer(spec);
  auto reader = other->create_reader(spec, nullptr);
  ASSERT_TRUE(writer && reader);

  EXPECT_TRUE(are_matched(**writer, **reader));
}

long open_files() {
  long count = 0;
  for (int file = 0; file < 1024; ++file) count += fcntl(file, F_GETFD) != -1 ? 1 : 0;
  return count;
}

long threads() {
  std::ifstream in("/proc/self/status");
  for (std::string word; in >> word;) {
    if (word == "Threads:") {
      in >> word;
      return std::stol(word);
    }
  }
  return -1;
}

class BusLifetime : public BusContract {};
INSTANTIATE_TEST_SUITE_P(Pairs, BusLifetime, kAllPairings, pairing_name);

TEST_P(BusLifetime, ClosingLeavesNeitherThreadsNorSockets) {
  const auto use = [&] {
    const TopicSpec spec = topic("contract/lifetime", keep_all(8));
    auto reader = make_reader(spec);
    auto writer = make_writer(spec);
    ASSERT_TRUE(writer->write(payload(1, 1)));
    reader.reset();
    writer.reset();
    writing_bus_.reset();
    reading_bus_.reset();
  };
  use();  // what a vendor keeps once for the process is there now
  const long files_before = open_files();
  const long threads_before = threads();

  for (int round = 0; round < 5; ++round) {
    SetUp();
    use();
  }

  EXPECT_EQ(open_files(), files_before);
  EXPECT_TRUE(eventually([&] { return threads() == threads_before; }))
      << threads() << ", was " << threads_before;
}

}  // namespace
}  // namespace tonus::bus::test
