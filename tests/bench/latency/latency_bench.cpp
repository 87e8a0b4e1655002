// From the publication of a block of samples to the live estimate that contains it, at a subscriber in
// another process, beside the bare round trip of the same carrier and size, and of UDP, measured in the same
// seconds.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>
#include <sstream>
#include <thread>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "tests/bench/latency/round_trip.hpp"
#include "tests/support/process.hpp"
#include "tests/support/short_session.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace tonus;
using Clock = std::chrono::steady_clock;

struct Row {
  std::string name;
  std::vector<double> values;  // ms

  [[nodiscard]] double at(double share) {
    if (values.empty()) return 0.0;
    const auto place =
        std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())));
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(place), values.end());
    return values[place];
  }
};

/// Follows the session until `run` has ended.
class Follower {
 public:
  Follower(bus::Bus& bus, const std::shared_ptr<bus::Notifier>& notifier)
      : notifier_(notifier),
        blocks_(*bus::TypedReader<v1::SampleBlock>::create(bus, topics::kRigSamples, notifier)),
        estimates_(*bus::TypedReader<v1::Estimate>::create(bus, topics::kEstimateLive, notifier)) {}

  void take() {
    (void)notifier_->wait_until(Clock::now() + std::chrono::milliseconds(100));
    std::vector<bus::Received<v1::Estimate>> estimates;
    estimates_.take(estimates);
    const std::int64_t now = Clock::now().time_since_epoch().count();
    std::vector<bus::Received<v1::SampleBlock>> blocks;
    blocks_.take(blocks);
    for (const auto& block : blocks) {
      if (block.value.is_resent() || block.value.samples().empty()) continue;
      sent_[block.value.first_sequence() + block.value.samples().size() - 1] = block.value.send_ns();
      block_bytes_ = block.sample.payload->size();
      block_samples_ = block.value.samples().size();
    }
    for (const auto& estimate : estimates) {
      estimate_bytes_ = estimate.sample.payload->size();
      if (!estimate.value.trials().empty())
        waiting_.emplace_back(estimate.value.trials().back().last_sequence(), now);
    }
    // The block itself may come later than its estimate.
    std::erase_if(waiting_, [this](const auto& each) {
      const auto sent = sent_.find(each.first);
      if (sent == sent_.end()) return false;
      results_.push_back(static_cast<double>(each.second - sent->second) * 1e-6);
      return true;
    });
  }

  [[nodiscard]] bool knows_sizes() const { return block_bytes_ > 0 && estimate_bytes_ > 0; }
  [[nodiscard]] std::size_t block_bytes() const { return block_bytes_; }
  [[nodiscard]] std::size_t block_samples() const { return block_samples_; }
  [[nodiscard]] std::size_t estimate_bytes() const { return estimate_bytes_; }
  [[nodiscard]] std::size_t unmatched() const { return waiting_.size(); }
  [[nodiscard]] const std::vector<double>& results() const { return results_; }

 private:
  std::shared_ptr<bus::Notifier> notifier_;
  bus::TypedReader<v1::SampleBlock> blocks_;
  bus::TypedReader<v1::Estimate> estimates_;
  std::map<std::uint64_t, std::int64_t> sent_;                   // by a block's last number
  std::vector<std::pair<std::uint64_t, std::int64_t>> waiting_;  // estimates whose block is not here yet
  std::size_t block_bytes_ = 0;
  std::size_t block_samples_ = 0;
  std::size_t estimate_bytes_ = 0;
  std::vector<double> results_;
};

bus::BusOptions options_for(const std::string& dds, int domain, const std::string& name) {
  bus::BusOptions options;
  options.vendor = *bus::parse_vendor(dds);
  options.domain = domain;
  options.participant_name = name;
  options.partition = "rig";  // of the default rig
  return options;
}

struct Asked {
  std::string dds = "fastdds";
  int directions = 8;
  bool is_json = false;
  std::string echo;  // of the program's own children
  int domain = 0;
  bench::TripSettings trips;
};

/// The two echoes, and the threads that talk to them.
class Yardsticks {
 public:
  Yardsticks(const Asked& asked, int domain, const bench::TripSettings& settings,
             const std::filesystem::path& folder)
      : bus_echo_("/proc/self/exe", words("bus", asked, domain, settings), folder / "bus-echo"),
        udp_echo_("/proc/self/exe", words("udp", asked, domain, settings), folder / "udp-echo") {
    bench::TripSettings udp = settings;
    const bool is_there = udp_echo_.wait_for_output("\n", std::chrono::seconds(10));
    udp.port = static_cast<std::uint16_t>(is_there ? std::stoi(udp_echo_.output()) : 0);
    bus_thread_ = std::thread([=, this] {
      bus_ = bench::bus_trips(options_for(asked.dds, domain, "bare-round-trip"), settings, is_over_);
    });
    udp_thread_ = std::thread([=, this] { udp_ = bench::udp_trips(udp, is_over_); });
  }
  ~Yardsticks() { finish(); }
  Yardsticks(const Yardsticks&) = delete;
  Yardsticks& operator=(const Yardsticks&) = delete;

  void finish() {
    is_over_ = true;
    if (bus_thread_.joinable()) bus_thread_.join();
    if (udp_thread_.joinable()) udp_thread_.join();
  }
  [[nodiscard]] const std::vector<double>& bus() const { return bus_; }
  [[nodiscard]] const std::vector<double>& udp() const { return udp_; }

 private:
  static std::vector<std::string> words(const char* echo, const Asked& asked, int domain,
                                        const bench::TripSettings& settings) {
    return {"--echo",   echo,
            "--dds",    asked.dds,
            "--domain", std::to_string(domain),
            "--back",   std::to_string(settings.back)};
  }

  testing::Process bus_echo_;
  testing::Process udp_echo_;
  std::atomic<bool> is_over_ = false;
  std::vector<double> bus_;
  std::vector<double> udp_;
  std::thread bus_thread_;
  std::thread udp_thread_;
};

void print(std::vector<Row> rows, const Follower& follower, const Asked& asked) {
  const double bare = rows[1].at(0.99);
  if (asked.is_json) {
    nlohmann::json json;
    for (Row& row : rows)
      json[row.name] = {{"count", row.values.size()},
                        {"p50_ms", row.at(0.5)},
                        {"p99_ms", row.at(0.99)},
                        {"p99.9_ms", row.at(0.999)},
                        {"over_bare_p99", row.at(0.99) / bare}};
    fmt::print("{}\n", nlohmann::json{{"dds", asked.dds},
                                      {"block_samples", follower.block_samples()},
                                      {"block_bytes", follower.block_bytes()},
                                      {"estimate_bytes", follower.estimate_bytes()},
                                      {"rows", json}}
                           .dump());
    return;
  }
  fmt::print("{}: blocks of {} samples ({} bytes), estimates of {} bytes, {} without their block\n",
             asked.dds, follower.block_samples(), follower.block_bytes(), follower.estimate_bytes(),
             follower.unmatched());
  for (Row& row : rows)
    fmt::print("  {:28} {:6} times  p50 {:7.2f}  p99 {:7.2f}  p99.9 {:7.2f} ms  {:5.2f} x bare p99\n",
               row.name, row.values.size(), row.at(0.5), row.at(0.99), row.at(0.999), row.at(0.99) / bare);
}

int measure(const Asked& asked) {
  const testing::TemporaryFolder folder;
  const int domain = testing::own_domain();
  testing::write_short_protocol(folder / "protocol.toml", asked.directions);
  std::ofstream(folder / "profile.toml")
      << "[loop]\nrate_Hz = 1000.0\nsample_divider = 1\n[limits]\n"
         "missed_periods = 2000\nmissed_share = 0\ncommand_timeout_s = 3.0\n";
  testing::Process up(
      testing::program("tonus"),
      {"up", "--speed", "real", "--resume-unattended", "--dds", asked.dds, "--domain", std::to_string(domain),
       "--data", (folder / "data").string(), "--profile", (folder / "profile.toml").string()},
      folder / "up");
  if (!up.wait_for_output("ready after", std::chrono::seconds(60))) {
    fmt::print(stderr, "latency_bench: the services are not ready: {}\n", up.output());
    return 1;
  }
  const auto notifier = std::make_shared<bus::Notifier>();
  auto bus = bus::create_bus(options_for(asked.dds, domain, "latency-bench"));
  if (!bus) {
    fmt::print(stderr, "latency_bench: {}\n", bus.error().message);
    return 1;
  }
  Follower follower(**bus, notifier);
  testing::Process run(testing::program("tonus"),
                       {"run", (folder / "protocol.toml").string(), "--dds", asked.dds, "--domain",
                        std::to_string(domain), "--data", (folder / "data").string()},
                       folder / "run");
  std::optional<Yardsticks> yardsticks;
  int code = testing::Process::kStillRunning;
  while ((code = run.wait(std::chrono::milliseconds(0))) == testing::Process::kStillRunning) {
    follower.take();
    if (yardsticks || !follower.knows_sizes()) continue;
    bench::TripSettings settings = asked.trips;
    settings.there = follower.block_bytes();
    settings.back = follower.estimate_bytes();
    yardsticks.emplace(asked, domain, settings, folder.path());
  }
  if (code != 0 || !yardsticks) {
    fmt::print(stderr, "latency_bench: the session failed: {}\n", run.output());
    return 1;
  }
  yardsticks->finish();
  print({{"block to estimate", follower.results()},
         {"bare round trip, " + asked.dds, yardsticks->bus()},
         {"bare round trip, UDP", yardsticks->udp()}},
        follower, asked);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("From a block of samples to the live estimate that contains it, beside bare round trips.",
               "latency_bench");
  Asked asked;
  app.add_option("--dds", asked.dds, "fastdds or cyclonedds")
      ->check(CLI::IsMember({"fastdds", "cyclonedds"}))
      ->capture_default_str();
  app.add_option("--directions", asked.directions, "perturbations, about 4 s each")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_flag("--json", asked.is_json, "one object instead of the table");
  app.add_option("--echo", asked.echo)->group("");
  app.add_option("--domain", asked.domain)->group("");
  app.add_option("--back", asked.trips.back)->group("");
  CLI11_PARSE(app, argc, argv);
  if (asked.echo == "bus")
    return bench::echo_on_bus(options_for(asked.dds, asked.domain, "bare-echo"), asked.trips);
  if (asked.echo == "udp") return bench::echo_on_udp(asked.trips);
  return measure(asked);
}
