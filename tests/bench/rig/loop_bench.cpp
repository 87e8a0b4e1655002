// The rig's loop in real time at its highest rate, beside a bare timer loop on the same machine at the same
// time: what of the lateness is ours, and what is the machine's. The whole path of the samples is there:
// loop, queue, agent, blocks, spool on the disk, bus (in memory), and a reader that checks every number.
//
//   rig_loop_bench --seconds 600 --seed 1
//   rig_loop_bench --seconds 600 --rate 1000 --emg 6        and --emg 0, for what the channels cost
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <spdlog/fmt/fmt.h>
#include <string>

#include "idl/topics.hpp"
#include "rig_agent/agent/agent.hpp"
#include "rig_agent/agent/loop_thread.hpp"
#include "rig_agent/agent/rig.hpp"
#include "services/bus/memory/memory_fabric.hpp"
#include "services/runtime/drain.hpp"
#include "services/simulation/muscles.hpp"
#include "tests/bench/rig/bare_timer.hpp"
#include "tests/support/needed.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus {
namespace {

using testing::needed;

struct BenchOptions {
  unsigned seconds = 60;
  double rate = 4000.0;
  unsigned divider = 1;
  double patience = 0.1;  ///< s without a cycle, at which the rig stops; a rig in use has 25 periods.
  std::uint64_t seed = 1;
  int priority = 80;
  unsigned emg = 0;  ///< Channels, each at twice the loop's rate.
};

/// What arrived at the other end of the bus.
struct Received {
  std::uint64_t samples = 0;
  std::uint64_t out_of_order = 0;  ///< Not the number after the one before.
  std::uint64_t stamps_back = 0;   ///< Not later than the one before.
  std::uint64_t next = 0;
  std::int64_t last_ns = -1;

  void take(const v1::SampleBlock& block) {
    std::uint64_t sequence = block.first_sequence();
    for (const auto& sample : block.samples()) {
      if (sequence != next) ++out_of_order;
      if (sample.acquisition_ns() <= last_ns) ++stamps_back;
      next = ++sequence;
      last_ns = sample.acquisition_ns();
      ++samples;
    }
  }
};

/// What arrived of the auxiliary channels.
struct ReceivedValues {
  std::uint64_t samples = 0;       ///< That have values.
  std::uint64_t out_of_order = 0;  ///< Not behind the block before.
  std::uint64_t not_measured = 0;  ///< Values, but for those before the first sample.
  std::uint64_t wrong_number = 0;  ///< Blocks with another number of values than their samples need.
  std::uint64_t next = 0;
  std::size_t values_per_sample = 0;

  void take(const v1::AuxiliaryBlock& block) {
    if (block.first_sequence() != next) ++out_of_order;
    if (block.values().size() != block.sample_count() * values_per_sample) ++wrong_number;
    next = block.first_sequence() + block.sample_count();
    samples += block.sample_count();
    const std::size_t begin = block.first_sequence() == 0 ? values_per_sample : 0;
    for (std::size_t i = begin; i < block.values().size(); ++i)
      not_measured += std::isnan(block.values()[i]) ? 1U : 0U;
  }
};

/// Lateness in us under which a share of the cycles began, between the edges of its class by a straight line.
double quantile_us(const control::JitterHistogram& jitter, double share) {
  std::uint64_t total = 0;
  for (std::size_t i = 0; i < control::JitterHistogram::kClasses; ++i) total += jitter.count(i);
  const double wanted = share * static_cast<double>(total);
  double below = 0.0;
  for (std::size_t i = 0; i < control::JitterHistogram::kClasses; ++i) {
    const auto here = static_cast<double>(jitter.count(i));
    if (here > 0.0 && below + here >= wanted) {
      const double low = i == 0 ? 0.0 : std::exp2(static_cast<double>(i) - 1.0);
      const double high =
          std::min(std::exp2(static_cast<double>(i)), 1e-3 * static_cast<double>(jitter.worst_ns()));
      return low + (std::max(high, low) - low) * (wanted - below) / here;
    }
    below += here;
  }
  return 1e-3 * static_cast<double>(jitter.worst_ns());
}

std::string ratio(double a, double b) { return b > 0.0 ? fmt::format("{:10.2f}", a / b) : "         -"; }

void print(const control::Pacer& loop, const control::Pacer& bare) {
  std::printf("%-26s %12s %12s\n", "late by", "loop", "bare timer");
  for (std::size_t i = 0; i < control::JitterHistogram::kClasses; ++i) {
    if (loop.jitter().count(i) + bare.jitter().count(i) == 0) continue;
    const std::string name = i == 0 ? "under 1 us"
                             : i + 1 < control::JitterHistogram::kClasses
                                 ? fmt::format("{} to {} us", 1 << (i - 1), 1 << i)
                                 : fmt::format("{} us and more", 1 << (i - 1));
    std::printf("%-26s %12lu %12lu\n", name.c_str(), loop.jitter().count(i), bare.jitter().count(i));
  }
  const auto line = [](const char* name, double a, double b) {
    std::printf("%-26s %12.1f %12.1f %s\n", name, a, b, ratio(a, b).c_str());
  };
  std::printf("%-26s %12s %12s %10s\n", "", "loop", "bare timer", "ratio");
  for (const double share : {0.5, 0.99, 0.999, 0.9999}) {
    line(fmt::format("{:g} % late by less, us", 100.0 * share).c_str(), quantile_us(loop.jitter(), share),
         quantile_us(bare.jitter(), share));
  }
  line("worst, us", 1e-3 * static_cast<double>(loop.jitter().worst_ns()),
       1e-3 * static_cast<double>(bare.jitter().worst_ns()));
  line("cycles", static_cast<double>(loop.cycles()), static_cast<double>(bare.cycles()));
  line("overruns", static_cast<double>(loop.overruns()), static_cast<double>(bare.overruns()));
  line("missed periods", static_cast<double>(loop.missed_periods()),
       static_cast<double>(bare.missed_periods()));
}

v1::TrialCommand trial(const rig::RigNames& names, std::uint32_t attempt) {
  const Id session = id_of("bench");
  v1::TrialCommand c;
  c.trial_id(trial_id(session, attempt));
  auto& p = c.program();
  p.session_id(session);
  p.rig_id(names.id);
  p.attempt(attempt);
  p.posture_m({0.0, 0.38});
  p.shoulder_origin_m({names.home.x(), names.home.y() - 0.38});
  p.direction_deg(45.0 * (attempt % 8));
  p.amplitude_m(0.005);
  p.rise_time_s(0.2);
  p.hold_s(1.5);
  p.wait_s(0.5);
  p.recording_index(-1);
  p.recording_event(-1);
  return c;
}

std::string profile_text(const BenchOptions& options) {
  std::string text = fmt::format(
      "[loop]\nrate_Hz = {:.1f}\nsample_divider = {}\n[limits]\nmissed_periods = {}\nmissed_share = 0\n",
      options.rate, options.divider, std::lround(options.patience * options.rate));
  for (unsigned i = 0; i < options.emg; ++i)
    text += fmt::format("[[auxiliary]]\nname = \"{}\"\ntype = \"EMG\"\nunit = \"mV\"\nrate_Hz = {:.1f}\n",
                        simulation::kMuscleNames[i], 2.0 * options.rate);
  return text;
}

int run(const BenchOptions& options) {
  const testing::TemporaryFolder folder;
  std::ofstream(folder / "profile.toml") << profile_text(options);
  rig::RigOptions rig_options;
  rig_options.profile = (folder / "profile.toml").string();
  rig_options.seed = options.seed;
  rig_options.fifo_priority = options.priority;

  bus::BusOptions bus_options;
  bus_options.vendor = bus::Vendor::kMemory;
  bus_options.fabric = std::make_shared<bus::MemoryFabric>();
  auto notifier = std::make_shared<bus::Notifier>();
  const SystemClock clock;
  auto bus = needed(bus::create_bus(bus_options));
  auto samples = needed(bus::TypedReader<v1::SampleBlock>::create(*bus, topics::kRigSamples, notifier));
  auto values = needed(bus::TypedReader<v1::AuxiliaryBlock>::create(*bus, topics::kRigAuxiliary, notifier));
  auto outcomes = needed(bus::TypedReader<v1::TrialOutcome>::create(*bus, topics::kTrialOutcome, notifier));
  auto commands = needed(bus::TypedWriter<v1::TrialCommand>::create(*bus, topics::kTrialCommand));

  auto rig = needed(rig::Rig::create(rig_options, "bench"));
  auto spool = needed(rig::Spool::open({.folder = folder / "spool"}));
  auto log = needed(rig::TrialLog::open(folder / "trials.log"));
  rig::Publisher publisher(
      {.rig = rig.names().id, .epoch = 1, .auxiliary_values = rig.loop().auxiliary_values()}, spool,
      needed(bus->create_writer(topics::kRigSamples.spec)),
      needed(bus->create_writer(topics::kRigAuxiliary.spec)), clock);
  auto latch = needed(rig::HoldLatch::open(folder / "hold"));
  rig::Lease lease(rig.names().id, 1);
  rig::StopRequests stops;
  rig::Agent agent({.names = rig.names(), .epoch = 1, .stillness = {}},
                   {rig.loop(), rig.driver(), nullptr, publisher, spool, log, latch, lease, stops},
                   needed(rig::AgentEndpoints::create(*bus, notifier)), clock);
  agent.start(rig::describe(rig.names(), rig.driver().geometry()));

  Received received;
  ReceivedValues auxiliary;
  auxiliary.values_per_sample = rig.loop().auxiliary_values();
  std::uint32_t attempts = 0;
  std::uint32_t completed = 0;
  BareTimer bare(std::llround(1e9 / options.rate), rig_options.realtime());
  rig::LoopThread loop(rig.loop(), true, rig_options.realtime());
  std::printf("%.0f Hz, every %u. cycle a sample, %u EMG channels of %.0f Hz, %u s, seed %lu; %s\n",
              options.rate, options.divider, options.emg, 2.0 * options.rate, options.seconds, options.seed,
              loop.statement().c_str());
  std::fflush(stdout);

  const auto begun = clock.now();
  const auto take = [&] {
    for (const auto& block : runtime::drain(samples)) received.take(block.value);
    for (const auto& block : runtime::drain(values)) auxiliary.take(block.value);
  };
  auto told = begun;
  if (auto sent = commands.write(trial(rig.names(), ++attempts)); !sent) return 1;
  while (clock.now() < begun + std::chrono::seconds(options.seconds)) {
    lease.arm(id_of("bench"), clock.now());  // the scheduler is always there
    (void)notifier->wait_until(std::min(agent.step(), clock.now() + std::chrono::milliseconds(5)));
    take();
    for (const auto& outcome : runtime::drain(outcomes)) {
      if (outcome.value.end() != v1::TRIAL_COMPLETED) continue;  // a fault: the samples go on
      ++completed;
      if (auto sent = commands.write(trial(rig.names(), ++attempts)); !sent) return 1;
    }
    if (clock.now() - told < std::chrono::seconds(30)) continue;
    told = clock.now();
    std::fprintf(stderr, "%.0f s: %lu samples, %u trials\n",
                 std::chrono::duration<double>(told - begun).count(), received.samples, completed);
  }
  const control::Pacer& loop_pacer = *loop.pacer();
  bare.stop();
  loop.stop();
  (void)agent.step();
  publisher.flush();
  take();

  const auto state = rig.loop().state();
  const std::uint64_t lost = state.next_sequence - received.samples;
  print(loop_pacer, bare.pacer());
  std::printf(
      "samples taken %lu, received %lu, lost %lu, dropped %lu, out of order %lu, stamps not increasing %lu\n",
      state.next_sequence, received.samples, lost, state.samples_dropped, received.out_of_order,
      received.stamps_back);
  bool has_values = true;
  if (options.emg > 0) {
    const std::uint64_t without = state.next_sequence - auxiliary.samples;
    std::printf(
        "samples without their values %lu, blocks out of order %lu, of a wrong size %lu, values not "
        "measured %lu, of %lu\n",
        without, auxiliary.out_of_order, auxiliary.wrong_number, auxiliary.not_measured,
        auxiliary.samples * auxiliary.values_per_sample);
    has_values = without + auxiliary.out_of_order + auxiliary.wrong_number + auxiliary.not_measured == 0;
  }
  std::printf("trials completed %u, the last one still running; faults 0x%x\n", completed, state.faults);
  return lost == 0 && received.out_of_order == 0 && received.stamps_back == 0 && state.faults == 0 &&
                 has_values
             ? 0
             : 1;
}

}  // namespace
}  // namespace tonus

int main(int argc, char** argv) {
  using namespace tonus;
  BenchOptions options;
  CLI::App app("The rig's loop in real time beside a bare timer loop.");
  app.add_option("--seconds", options.seconds, "length")->check(CLI::Range(1, 86'400))->capture_default_str();
  app.add_option("--rate", options.rate, "of the loop, Hz")
      ->check(CLI::Range(500.0, 4000.0))
      ->capture_default_str();
  app.add_option("--divider", options.divider, "cycles a sample")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_option("--patience", options.patience, "s without a cycle, at which the rig stops")
      ->check(CLI::Range(0.001, 2.0))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "of the simulated noise")->capture_default_str();
  app.add_option("--priority", options.priority, "SCHED_FIFO of both loops; 0: none")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  app.add_option("--emg", options.emg, "channels, each at twice the loop's rate")
      ->check(CLI::Range(0U, static_cast<unsigned>(simulation::kMuscles)))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    return run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rig_loop_bench: %s\n", error.what());
    return 1;
  }
}
