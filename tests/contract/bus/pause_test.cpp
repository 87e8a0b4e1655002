#include <algorithm>
#include <csignal>
#include <set>

#include "tests/contract/bus/contract_fixture.hpp"

namespace tonus::bus::test {
namespace {

using tonus::test::ChildProcess;
using tonus::test::eventually;

constexpr int kPeers = 4;

/// Processes that each tell a state and print whose they hear, and this process, which listens to them.
class BusAfterAPause : public testing::TestWithParam<Vendor> {
 protected:
  void SetUp() override {
    BusOptions options = bus_options(GetParam());
    options.participant_lease = std::chrono::milliseconds{1000};
    bus_ = open_bus(options);
    auto reader = bus_->create_reader(topic("peer/gossip", watched_state()), nullptr);
    ASSERT_TRUE(reader);
    reader_ = std::move(*reader);
    for (int key = 0; key < kPeers; ++key) {
      peers_.push_back(std::make_unique<ChildProcess>(
          std::vector<std::string>{TONUS_BUS_PEER, std::string(vendor_name(GetParam())),
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

  void signal_all(int signal) const {
    for (const auto& peer : peers_) peer->send_signal(signal);
  }
  [[nodiscard]] bool hears(int writers) const {
    return eventually([&] { return reader_->status().matched_writers == writers; });
  }

  std::unique_ptr<Bus> bus_;
  std::unique_ptr<Reader> reader_;
  std::vector<std::unique_ptr<ChildProcess>> peers_;
};
INSTANTIATE_TEST_SUITE_P(Carriers, BusAfterAPause, testing::Values(Vendor::kFastDds, Vendor::kCycloneDds),
                         carrier_name);

/// All of them stand still until their leases are over, so that each drops each when it goes on. The long
/// form is rig_pause_campaign, with whole systems.
TEST_P(BusAfterAPause, ProcessesThatWereAllStoppedHearEachOtherAgain) {
  ASSERT_TRUE(each_hears_each());
  for (int pause = 0; pause < 4; ++pause) {
    signal_all(SIGSTOP);
    const bool are_dropped = hears(0);
    signal_all(SIGCONT);
    ASSERT_TRUE(are_dropped);
    ASSERT_TRUE(hears(kPeers));
    ASSERT_TRUE(each_hears_each()) << "pause " << pause;
  }
}

}  // namespace
}  // namespace tonus::bus::test
