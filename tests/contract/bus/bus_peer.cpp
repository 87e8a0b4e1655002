// The other process in the bus's contract tests: bus_peer VENDOR DOMAIN (write FIRST | read DEPTH | gossip
// KEY)
//   write: publishes a watched state under "peer/state", numbers from FIRST on, several a second, until
//   killed. read:  prints the number of every sample of "peer/samples", kept in full.
//   gossip: publishes a state under KEY ten times a second, and prints the keys that it hears as often.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/contract/bus/test_topics.hpp"

namespace tonus::bus {
namespace {

int complain(const Error& error) {
  std::fprintf(stderr, "bus_peer: %s\n", error.message.c_str());
  return 1;
}

int write_states(Bus& bus, std::uint64_t number) {
  auto writer = bus.create_writer(test::topic("peer/state", test::watched_state()));
  if (!writer) return complain(writer.error());
  Notifier pace;
  for (;; ++number) {
    if (auto written = (*writer)->write(test::payload(1, number)); !written) return complain(written.error());
    static_cast<void>(pace.wait_until(std::chrono::steady_clock::now() + std::chrono::milliseconds{50}));
  }
}

int read_samples(Bus& bus, int depth) {
  auto notifier = std::make_shared<Notifier>();
  auto reader = bus.create_reader(test::topic("peer/samples", test::keep_all(depth)), notifier);
  if (!reader) return complain(reader.error());
  std::vector<Sample> samples;
  for (;;) {
    static_cast<void>(notifier->wait_until(std::chrono::steady_clock::now() + std::chrono::seconds{1}));
    while ((*reader)->take(samples) > 0) {
    }
    for (const Sample& sample : samples)
      std::printf("%llu\n", static_cast<unsigned long long>(test::number_in(*sample.payload)));
    std::fflush(stdout);
    samples.clear();
  }
}

int gossip(Bus& bus, std::uint8_t key) {
  const auto notifier = std::make_shared<Notifier>();
  const TopicSpec spec = test::topic("peer/gossip", test::watched_state());
  auto writer = bus.create_writer(spec);
  auto reader = bus.create_reader(spec, notifier);
  if (!writer) return complain(writer.error());
  if (!reader) return complain(reader.error());
  constexpr std::chrono::milliseconds kPeriod{100};
  Notifier pace;
  std::vector<Sample> samples;
  for (std::uint64_t number = 0;; ++number) {
    (void)(*writer)->write(test::payload(key, number));  // a later one follows
    static_cast<void>(pace.wait_until(std::chrono::steady_clock::now() + kPeriod));
    while ((*reader)->take(samples) > 0) {
    }
    for (const Sample& sample : samples) std::printf("%d\n", static_cast<int>(sample.key[15]));
    std::fflush(stdout);
    samples.clear();
  }
}

int run(int count, char** arguments) {
  if (count != 5) return complain({ErrorCode::kInvalidArgument, "needs VENDOR DOMAIN MODE NUMBER"});
  const auto vendor = parse_vendor(arguments[1]);
  if (!vendor) return complain(vendor.error());
  BusOptions options;
  options.vendor = *vendor;
  options.domain = std::atoi(arguments[2]);
  options.participant_name = "bus_peer";
  options.participant_lease = std::chrono::milliseconds{1000};
  auto bus = create_bus(options);
  if (!bus) return complain(bus.error());
  const long number = std::atol(arguments[4]);
  if (std::string(arguments[3]) == "write") return write_states(**bus, static_cast<std::uint64_t>(number));
  if (std::string(arguments[3]) == "gossip") return gossip(**bus, static_cast<std::uint8_t>(number));
  return read_samples(**bus, static_cast<int>(number));
}

}  // namespace
}  // namespace tonus::bus

int main(int count, char** arguments) { return tonus::bus::run(count, arguments); }
