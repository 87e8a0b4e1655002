// Damaged and made-up inputs to everything that reads what others wrote. Worth most in a build with
// sanitizers.

#include <CLI/CLI.hpp>
#include <chrono>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "tests/fuzz/target.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using tonus::fuzz::Damage;
using tonus::fuzz::Target;
using Clock = std::chrono::steady_clock;

/// Runs inputs of the seeds from `seed` on, until the time is over.
bool run(Target& target, std::uint64_t seed, double seconds) {
  const bool is_terminal = ::isatty(STDERR_FILENO) == 1;
  const auto start = Clock::now();
  const auto end =
      start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  auto shown = start;
  std::uint64_t inputs = 0;
  std::uint64_t refused = 0;
  do {
    Damage damage(seed + inputs);
    const auto outcome = target.run(damage);
    if (!outcome) {
      fmt::print("{}: seed {}: {}\n", target.name(), seed + inputs, outcome.error().message);
      return false;
    }
    ++inputs;
    refused += *outcome ? 1 : 0;
    if (is_terminal && Clock::now() - shown > std::chrono::milliseconds(500)) {
      shown = Clock::now();
      fmt::print(stderr, "\r{}: {} inputs, {:.0f} of {:.0f} s", target.name(), inputs,
                 std::chrono::duration<double>(shown - start).count(), seconds);
    }
  } while (Clock::now() < end);
  if (is_terminal) fmt::print(stderr, "\r");
  fmt::print("{}: {} inputs from seed {}: {} refused with a message, {} taken, no crash\n", target.name(),
             inputs, seed, refused, inputs - refused);
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Damaged inputs to everything that reads what others wrote.", "archive_fuzz");
  std::uint64_t seed = 1;
  double seconds = 10.0;
  std::string tonus = tonus::testing::program("tonus").string();
  app.add_option("--seed", seed, "of the first input; the next one has the next")->capture_default_str();
  app.add_option("--seconds", seconds, "for each target")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--tonus", tonus, "program whose recover and import are tried too")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  spdlog::set_level(spdlog::level::off);
  const tonus::testing::TemporaryFolder folder;
  std::vector<std::unique_ptr<Target>> targets;
  targets.push_back(tonus::fuzz::make_message_target());
  for (const char* name : {"stores", "datasets", "programs"})
    std::filesystem::create_directory(folder / name);
  targets.push_back(tonus::fuzz::make_store_target(folder / "stores"));
  targets.push_back(tonus::fuzz::make_dataset_target(folder / "datasets"));
  if (auto programs = tonus::fuzz::make_program_target(folder / "programs", tonus))
    targets.push_back(std::move(programs));
  bool is_good = true;
  for (const auto& target : targets) is_good = run(*target, seed, seconds) && is_good;
  return is_good ? 0 : 1;
}
