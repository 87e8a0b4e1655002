#include <algorithm>
#include <array>
#include <csignal>
#include <set>

#include "tests/contract/bus/contract_fixture.hpp"

namespace tonus::bus::test {
namespace {

using tonus::test::ChildProcess;
using tonus::test::eventually;

constexpr int kPeers = 4;

/// Whose implementation each process has: this one, which never stands still, and its peers.
struct Company {
  const char* name;
  Vendor listener;
  std::array<Vendor, kPeers> peers;
};

constexpr Company kCompanies[] = {
    {"fastdds", Vendor::kFastDds, {Vendor::kFastDds, Vendor::kFastDds, Vendor::kFastDds, Vendor::kFastDds}},
    {"cyclonedds",
     Vendor::kCycloneDds,
     {Vendor::kCycloneDds, Vendor::kCycloneDds, Vendor::kCycloneDds, Vendor::kCycloneDds}},
    {"cyclonedds_to_fastdds",
     Vendor::kFastDds,
     {Vendor::kCycloneDds, Vendor::kCycloneDds, Vendor::kFastDds, Vendor::kCycloneDds}},
    {"fastdds_to_cyclonedds",
     Vendor::kCycloneDds,
     {Vendor::kFastDds, Vendor::kFastDds, Vendor::kCycloneDds, Vendor::kFastDds}},
};

/// Processes that each tell a state and print whose they hear, and this process, which listens to them.
class BusAfterAPause : public testing::TestWithParam<Company> {
 protected:
  void SetUp() override {
    BusOptions options = bus_options(GetParam().listener);
    options.participant_lease = std::chrono::milliseconds{1000};
    bus_ = open_bus(options);
    auto reader = bus_->create_reader(topic("peer/gossip", watched_state()), nullptr);
    ASSERT_TRUE(reader);
    reader_ = std::move(*reader);
    for (int key = 0; key < kPeers; ++key) {
      const Vendor vendor = GetParam().peers.at(static_cast<std::size_t>(key));
      peers_.push_back(std::make_unique<ChildProcess>(
          std::vector<std::string>{TONUS_BUS_PEER, std::string(vendor_name(vendor)),
                                   std::to_string(test_domain()), "gossip", std::to_string(key)}));
    }
  }

  /// From now on each hears each, itself too.
  [[nodiscard]] bool each_hears_each() {
    for (const auto& peer : peers_) (void)peer->take_lines();
    std::vector<std::set<std::string>> heard(kPeers);
    return eventually([&] {
      for (std::size_t i = 0; i < kPeers; ++i) {
        for (const std::string& line : peers_[i]->take_lines()) heard[i].insert(line);
      }
      return std::ranges::all_of(heard, [](const auto& keys) { return keys.size() == kPeers; });
    });
  }

  /// From now on this process gets states of so many of them, and knows as many writers.
  [[nodiscard]] bool hears(int writers) {
    std::vector<Sample> heard;
    while (reader_->take(heard) > 0) heard.clear();
    std::set<Key> keys;
    return eventually([&] {
      heard.clear();
      (void)reader_->take(heard);
      for (const Sample& sample : heard) keys.insert(sample.key);
      return static_cast<int>(keys.size()) >= writers && reader_->status().matched_writers == writers;
    });
  }
  void signal_first(int count, int signal) const {
    for (int i = 0; i < count; ++i) peers_[static_cast<std::size_t>(i)]->send_signal(signal);
  }

  std::unique_ptr<Bus> bus_;
  std::unique_ptr<Reader> reader_;
  std::vector<std::unique_ptr<ChildProcess>> peers_;
};
INSTANTIATE_TEST_SUITE_P(Carriers, BusAfterAPause, testing::ValuesIn(kCompanies),
                         [](const auto& one) { return std::string(one.param.name); });

/// All or some of them stand still until their leases are over, so that each drops each when it goes on. The
/// long form is rig_pause_campaign, with whole systems.
TEST_P(BusAfterAPause, ProcessesThatWereStoppedHearEachOtherAgain) {
  ASSERT_TRUE(hears(kPeers));
  ASSERT_TRUE(each_hears_each());
  for (const int stopped : {kPeers, 2, kPeers, 1, kPeers, 3}) {
    signal_first(stopped, SIGSTOP);
    const bool are_dropped = hears(kPeers - stopped);
    signal_first(stopped, SIGCONT);
    ASSERT_TRUE(are_dropped) << stopped << " were stopped, " << reader_->status().matched_writers
                             << " writers are known";
    ASSERT_TRUE(hears(kPeers)) << stopped << " were stopped";
    ASSERT_TRUE(each_hears_each()) << stopped << " were stopped";
  }
}

}  // namespace
}  // namespace tonus::bus::test
