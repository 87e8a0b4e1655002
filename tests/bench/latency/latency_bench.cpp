// From the publication of a block of samples to the live estimate that contains it, at a subscriber in
// another process, beside the bare round trip of the same carrier and size, and of UDP, measured in the same
// seconds. With --secured in sessions without and with DDS security in turn.

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
#include "tests/bench/bench_bus.hpp"
#include "tests/bench/latency/round_trip.hpp"
#include "tests/bench/latency/secured_host.hpp"
#include "tests/support/process.hpp"
#include "tests/support/short_session.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace tonus;
using Clock = std::chrono::steady_clock;

struct Row {
  std::string name;
  std::vector<double> values{};  // ms

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

struct Asked {
  std::string dds = "fastdds";
  int directions = 8;
  bool is_json = false;
  bool is_secured = false;
  int rounds = 1;
  std::string echo;  // of the program's own children
  int domain = 0;
  std::string security;  // folder of the host's certificates; empty: none
  bench::TripSettings trips;
};

bus::BusOptions options_for(const Asked& asked, int domain, const std::string& name) {
  bus::BusOptions options = bench::bus_options(asked.dds, domain, name);
  options.partition = "rig";  // of the default rig
  if (!asked.security.empty()) options.security = bench::bench_files(asked.security);
  return options;
}

std::vector<std::string> with_security(const Asked& asked, std::vector<std::string> words) {
  if (!asked.security.empty()) words.insert(words.end(), {"--security", asked.security});
  return words;
}

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
      bus_ = bench::bus_trips(options_for(asked, domain, "bare-round-trip"), settings, is_over_);
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
    return with_security(asked, {"--echo", echo, "--dds", asked.dds, "--domain", std::to_string(domain),
                                 "--back", std::to_string(settings.back)});
  }

  testing::Process bus_echo_;
  testing::Process udp_echo_;
  std::atomic<bool> is_over_ = false;
  std::vector<double> bus_;
  std::vector<double> udp_;
  std::thread bus_thread_;
  std::thread udp_thread_;
};

/// What one session gave, or several of one kind together.
struct Measured {
  Row estimate{"block to estimate"};
  Row bus{"bare round trip, bus"};
  Row udp{"bare round trip, UDP"};
  std::size_t block_samples = 0;
  std::size_t block_bytes = 0;
  std::size_t estimate_bytes = 0;
  std::size_t unmatched = 0;

  void add(const Measured& other) {
    const auto append = [](Row& row, const Row& more) {
      row.values.insert(row.values.end(), more.values.begin(), more.values.end());
    };
    append(estimate, other.estimate);
    append(bus, other.bus);
    append(udp, other.udp);
    block_samples = other.block_samples;
    block_bytes = other.block_bytes;
    estimate_bytes = other.estimate_bytes;
    unmatched += other.unmatched;
  }
};

nlohmann::json json_of(Row& row, double bare) {
  return {{"count", row.values.size()},
          {"p50_ms", row.at(0.5)},
          {"p99_ms", row.at(0.99)},
          {"p99.9_ms", row.at(0.999)},
          {"over_bare_p99", row.at(0.99) / bare}};
}

nlohmann::json json_of(Measured& measured, const Asked& asked) {
  const double bare = measured.bus.at(0.99);
  return {{"dds", asked.dds},
          {"block_samples", measured.block_samples},
          {"block_bytes", measured.block_bytes},
          {"estimate_bytes", measured.estimate_bytes},
          {"rows",
           {{measured.estimate.name, json_of(measured.estimate, bare)},
            {"bare round trip, " + asked.dds, json_of(measured.bus, bare)},
            {measured.udp.name, json_of(measured.udp, bare)}}}};
}

void print(Measured& measured, const Asked& asked, const char* kind) {
  fmt::print("{}{}: blocks of {} samples ({} bytes), estimates of {} bytes, {} without their block\n",
             asked.dds, kind, measured.block_samples, measured.block_bytes, measured.estimate_bytes,
             measured.unmatched);
  const double bare = measured.bus.at(0.99);
  for (Row* row : {&measured.estimate, &measured.bus, &measured.udp})
    fmt::print("  {:28} {:6} times  p50 {:7.2f}  p99 {:7.2f}  p99.9 {:7.2f} ms  {:5.2f} x bare p99\n",
               row->name, row->values.size(), row->at(0.5), row->at(0.99), row->at(0.999),
               row->at(0.99) / bare);
}

/// Both kinds, and what security costs.
void print_beside(Measured& plain, Measured& secured, const Asked& asked) {
  if (asked.is_json) {
    fmt::print("{}\n",
               nlohmann::json{{"plain", json_of(plain, asked)}, {"secured", json_of(secured, asked)}}.dump());
    return;
  }
  print(plain, asked, ", without security");
  print(secured, asked, ", secured");
  const auto ratio = [](Row& with, Row& without) {
    return fmt::format("p50 {:.2f}, p99 {:.2f}, p99.9 {:.2f}", with.at(0.5) / without.at(0.5),
                       with.at(0.99) / without.at(0.99), with.at(0.999) / without.at(0.999));
  };
  fmt::print(
      "secured over without security: block to estimate {}; bare round trip {}; UDP, which has none, {}\n",
      ratio(secured.estimate, plain.estimate), ratio(secured.bus, plain.bus), ratio(secured.udp, plain.udp));
}

Result<Measured> measure(const Asked& asked) {
  const testing::TemporaryFolder folder;
  const int domain = asked.domain;
  testing::write_short_protocol(folder / "protocol.toml", asked.directions);
  std::ofstream(folder / "profile.toml")
      << "[loop]\nrate_Hz = 1000.0\nsample_divider = 1\n[limits]\n"
         "missed_periods = 2000\nmissed_share = 0\ncommand_timeout_s = 3.0\n";
  testing::Process up(
      testing::program("tonus"),
      with_security(asked, {"up", "--speed", "real", "--resume-unattended", "--dds", asked.dds, "--domain",
                            std::to_string(domain), "--data", (folder / "data").string(), "--profile",
                            (folder / "profile.toml").string()}),
      folder / "up");
  if (!up.wait_for_output("ready after", std::chrono::seconds(60)))
    return fail(ErrorCode::kUnavailable, "the services are not ready: " + up.output());
  const auto notifier = std::make_shared<bus::Notifier>();
  TONUS_TRY_ASSIGN(const auto bus, bus::create_bus(options_for(asked, domain, "latency-bench")));
  Follower follower(*bus, notifier);
  testing::Process run(
      testing::program("tonus"),
      with_security(asked, {"run", (folder / "protocol.toml").string(), "--dds", asked.dds, "--domain",
                            std::to_string(domain), "--data", (folder / "data").string()}),
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
  if (code != 0 || !yardsticks) return fail(ErrorCode::kUnavailable, "the session failed: " + run.output());
  yardsticks->finish();
  Measured measured;
  measured.estimate.values = follower.results();
  measured.bus.values = yardsticks->bus();
  measured.udp.values = yardsticks->udp();
  measured.block_samples = follower.block_samples();
  measured.block_bytes = follower.block_bytes();
  measured.estimate_bytes = follower.estimate_bytes();
  measured.unmatched = follower.unmatched();
  return measured;
}

/// Sessions in turn, so that whatever else the machine does falls on both kinds.
Result<void> measure_and_print(Asked asked) {
  asked.domain = testing::own_domain();
  const testing::TemporaryFolder folder;
  std::string security;
  if (asked.is_secured) {
    TONUS_TRY_ASSIGN(security, bench::make_secured_host(folder / "pki", asked.dds));
  }
  Measured plain;
  Measured secured;
  for (int round = 0; round < asked.rounds; ++round) {
    asked.security.clear();
    TONUS_TRY_ASSIGN(const auto one, measure(asked));
    plain.add(one);
    if (!asked.is_secured) continue;
    asked.security = security;
    TONUS_TRY_ASSIGN(const auto other, measure(asked));
    secured.add(other);
  }
  if (asked.is_secured)
    print_beside(plain, secured, asked);
  else if (asked.is_json)
    fmt::print("{}\n", json_of(plain, asked).dump());
  else
    print(plain, asked, "");
  return {};
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
  app.add_flag("--secured", asked.is_secured, "sessions with DDS security beside those without");
  app.add_option("--rounds", asked.rounds, "sessions of each kind, in turn")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_flag("--json", asked.is_json, "one object instead of the table");
  app.add_option("--echo", asked.echo)->group("");
  app.add_option("--domain", asked.domain)->group("");
  app.add_option("--security", asked.security)->group("");
  app.add_option("--back", asked.trips.back)->group("");
  CLI11_PARSE(app, argc, argv);
  if (asked.echo == "bus")
    return bench::echo_on_bus(options_for(asked, asked.domain, "bare-echo"), asked.trips);
  if (asked.echo == "udp") return bench::echo_on_udp(asked.trips);
  if (const auto done = measure_and_print(asked); !done) {
    fmt::print(stderr, "latency_bench: {}\n", done.error().message);
    return 1;
  }
  return 0;
}
