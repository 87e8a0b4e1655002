// fault_simulator: whole sessions in one thread, by a simulated clock, under faults from a seed.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <spdlog/spdlog.h>

#include "tests/fault/simulator/simulation.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace tonus;

struct Options {
  unsigned long sessions = 100;
  std::uint64_t seed = 1;
  unsigned steps = 6;
  int trials = 8;
  double seconds = 0.0;
  unsigned shrinks = 40;
  std::string scenario;
  bool is_traced = false;
};

simulator::SimulationOptions of(const Options& options, std::uint64_t seed) {
  return {.seed = seed, .trials = options.trials, .is_quiet = !options.is_traced};
}

/// Says what was broken, the shortest scenario that was found for it, and how to see it again.
void explain(const testing::Scenario& scenario, const std::string& broken, const Options& options,
             std::uint64_t seed) {
  const auto breaks = [&](const testing::Scenario& shorter) {
    return !simulator::simulate(shorter, of(options, seed)).broken.empty();
  };
  const auto shortest = testing::shrink(scenario, breaks, options.shrinks);
  std::printf("seed %llu: %s\nBROKEN\n%sagain: fault_simulator --seed %llu --trials %d --scenario '%s'\n",
              static_cast<unsigned long long>(seed), testing::to_text(scenario).c_str(), broken.c_str(),
              static_cast<unsigned long long>(seed), options.trials, testing::to_text(shortest).c_str());
  std::fflush(stdout);
}

int run_one(const Options& options) {
  testing::Scenario scenario;
  if (options.scenario != "none") {
    const auto parsed = testing::parse_scenario(options.scenario);
    if (!parsed) return std::fprintf(stderr, "fault_simulator: %s\n", parsed.error().message.c_str()), 2;
    scenario = *parsed;
  }
  const auto outcome = simulator::simulate(scenario, of(options, options.seed));
  std::printf("%u trials counted in %.1f simulated s, trace %016llx\n%s", outcome.trials, outcome.simulated,
              static_cast<unsigned long long>(outcome.hash),
              outcome.broken.empty() ? "held\n" : ("BROKEN\n" + outcome.broken).c_str());
  return outcome.broken.empty() ? 0 : 1;
}

int run_all(const Options& options) {
  const auto begun = std::chrono::steady_clock::now();
  const auto passed = [begun] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  };
  unsigned long sessions = 0;
  unsigned long broken = 0;
  unsigned long trials = 0;
  std::uint64_t hash = 0;
  while (sessions < options.sessions && (options.seconds <= 0.0 || passed() < options.seconds)) {
    const std::uint64_t seed = options.seed + sessions++;
    const auto scenario = testing::draw_simulated_scenario(seed, options.steps);
    const auto outcome = simulator::simulate(scenario, of(options, seed));
    trials += outcome.trials;
    hash = hash * 31 + outcome.hash;
    if (outcome.broken.empty()) continue;
    ++broken;
    explain(scenario, outcome.broken, options, seed);
  }
  std::printf(
      "%lu sessions of %u steps from seed %llu, %lu trials counted, %lu broken; %.1f s, %.1f trials/s; "
      "trace %016llx\n",
      sessions, options.steps, static_cast<unsigned long long>(options.seed), trials, broken, passed(),
      static_cast<double>(trials) / passed(), static_cast<unsigned long long>(hash));
  return broken == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Whole sessions in one thread under faults from a seed; the same seed gives the same trace.");
  Options options;
  app.add_option("--sessions", options.sessions, "how many at most")->capture_default_str();
  app.add_option("--seconds", options.seconds, "begin no session after so long; 0: no limit")
      ->capture_default_str();
  app.add_option("--seed", options.seed, "of the first; each next has the next number")
      ->capture_default_str();
  app.add_option("--steps", options.steps, "faults in each")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  app.add_option("--trials", options.trials, "planned in each")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--shrink", options.shrinks, "most runs to shorten a failure")->capture_default_str();
  app.add_option("--scenario", options.scenario,
                 "one, as this program prints it, instead of drawn ones; none: without a fault");
  app.add_flag("--trace", options.is_traced, "the programs' log, with the simulated time");
  CLI11_PARSE(app, argc, argv);
  spdlog::set_level(options.is_traced ? spdlog::level::debug : spdlog::level::off);
  ::setenv("TMPDIR", "/dev/shm", 1);  // files in memory
  const testing::TemporaryFolder folder;
  std::filesystem::current_path(folder.path());
  const int code = options.scenario.empty() ? run_all(options) : run_one(options);
  std::filesystem::current_path("/");
  return code;
}
