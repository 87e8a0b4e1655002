// fault_scenarios: sessions in real time under random faults, with an operator; a failure is shrunk.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "tests/fault/scenario/scenario.hpp"

namespace {

using namespace tonus;

struct Options {
  unsigned scenarios = 100;
  unsigned steps = 3;
  std::uint64_t seed = 1;
  unsigned shrinks = 8;
  std::string dds = "both";
  std::string scenario;
};

/// Runs one and says so; false where an invariant was broken.
bool run(const testing::Scenario& scenario, const std::string& dds, const Options& options) {
  std::printf("%s: %s ... ", dds.c_str(), testing::to_text(scenario).c_str());
  std::fflush(stdout);
  const auto broken = testing::run_scenario(scenario, dds);
  if (broken && broken->empty()) return std::puts("held"), true;
  std::printf("BROKEN\n%s\n", broken ? broken->c_str() : broken.error().message.c_str());
  if (broken && scenario.size() > 1) {
    const auto breaks = [&dds](const testing::Scenario& shorter) {
      const auto again = testing::run_scenario(shorter, dds);
      return again && !again->empty();
    };
    std::printf("shortest that breaks: --dds %s --scenario '%s'\n", dds.c_str(),
                testing::to_text(testing::shrink(scenario, breaks, options.shrinks)).c_str());
  }
  return false;
}

int run_all(const Options& options) {
  unsigned broken = 0;
  for (unsigned i = 0; i < options.scenarios; ++i) {
    const std::uint64_t seed = options.seed + i;
    const std::string dds = options.dds != "both" ? options.dds : seed % 2 == 0 ? "cyclonedds" : "fastdds";
    std::printf("%u of %u, seed %llu, ", i + 1, options.scenarios, static_cast<unsigned long long>(seed));
    if (!run(testing::draw_scenario(seed, options.steps), dds, options)) ++broken;
  }
  std::printf("%u scenarios of %u steps, %u broken\n", options.scenarios, options.steps, broken);
  return broken == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Sessions in real time under kills, pauses, restarts and stops; nothing may move unasked.");
  Options options;
  app.add_option("--scenarios", options.scenarios, "how many")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app.add_option("--steps", options.steps, "faults in each")->check(CLI::Range(1, 20))->capture_default_str();
  app.add_option("--seed", options.seed, "of the first; each next has the next number")
      ->capture_default_str();
  app.add_option("--shrink", options.shrinks, "most runs to shorten a failure")->capture_default_str();
  app.add_option("--dds", options.dds, "vendor of all programs; both takes turns")
      ->check(CLI::IsMember({"fastdds", "cyclonedds", "both"}))
      ->capture_default_str();
  app.add_option("--scenario", options.scenario, "one, as this program prints it, instead of drawn ones");
  CLI11_PARSE(app, argc, argv);
  if (options.scenario.empty()) return run_all(options);
  const auto scenario = testing::parse_scenario(options.scenario);
  if (!scenario) return std::fprintf(stderr, "fault_scenarios: %s\n", scenario.error().message.c_str()), 2;
  return run(*scenario, options.dds == "both" ? "fastdds" : options.dds, options) ? 0 : 1;
}
