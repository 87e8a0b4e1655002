// cohort-campaign: how firmly the study's cohort gives back its own truth, over many seeds of tremor, drift
// and sensor noise.

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>

#include "analysis_service/report/spread.hpp"
#include "analysis_service/report/tables.hpp"
#include "tests/acceptance/simulated_cohort.hpp"
#include "tests/support/process.hpp"

namespace {

using namespace tonus;

int run(const std::string& file, std::uint64_t first, unsigned seeds) {
  const auto cohort = simulation::load_cohort(file);
  if (!cohort) {
    std::fprintf(stderr, "cohort-campaign: %s\n", cohort.error().message.c_str());
    return 2;
  }
  std::array<report::EntriesWithin, 3> sums{{{"I"}, {"III"}, {"IV"}}};
  for (std::uint64_t seed = first; seed < first + seeds; ++seed) {
    const auto study = testing::simulate_cohort(*cohort, seed);
    if (!study) {
      std::fprintf(stderr, "cohort-campaign: seed %llu: %s\n", static_cast<unsigned long long>(seed),
                   study.error().message.c_str());
      return 2;
    }
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    const auto tables = report::entries_within_spread(*study);
    for (std::size_t i = 0; i < sums.size(); ++i) {
      sums[i].inside += tables[i].inside;
      sums[i].all += tables[i].all;
      if (!tables[i].outside.empty())
        std::printf("  outside in Table %s: %s\n", tables[i].table.c_str(), tables[i].outside.c_str());
    }
    for (const auto& row : report::coverage_table(*study).rows) {
      std::printf("  %-15s inside the intervals: M %s, B %s, K %s; bias M %s, B %s, K %s\n", row[0].c_str(),
                  row[1].c_str(), row[2].c_str(), row[3].c_str(), row[4].c_str(), row[5].c_str(),
                  row[6].c_str());
    }
    std::fflush(stdout);
  }
  bool is_every_one_inside = true;
  for (const auto& sum : sums) {
    std::printf("Table %s: %d of %d within the published spread\n", sum.table.c_str(), sum.inside, sum.all);
    is_every_one_inside &= sum.all > 0 && sum.inside == sum.all;
  }
  return is_every_one_inside ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  std::string cohort = testing::source_file("deploy/profiles/cohort.toml").string();
  std::uint64_t seed = 1;
  unsigned seeds = 6;
  CLI::App app(
      "Measures a simulated cohort over and over, in one process, and counts the entries of Tables I, III "
      "and IV "
      "within the published spread of its truth. Exit code 1: not all are.",
      "cohort-campaign");
  app.add_option("--cohort", cohort, "the cohort's file")->capture_default_str();
  app.add_option("--seed", seed, "the first seed")->capture_default_str();
  app.add_option("--seeds", seeds, "how many")->capture_default_str()->check(CLI::Range(1U, 10000U));
  CLI11_PARSE(app, argc, argv);
  return run(cohort, seed, seeds);
}
