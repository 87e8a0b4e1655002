// rig_stop_campaign: how long an operator's stop takes, whatever goes on around the rig.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "tests/fault/stop/stop_bench.hpp"

namespace {

using namespace tonus;

void print(const std::string& what, std::vector<double> ms) {
  if (ms.empty()) return;
  std::sort(ms.begin(), ms.end());
  std::printf("| %s | %zu | %.1f | %.1f | %.1f |\n", what.c_str(), ms.size(), ms[ms.size() / 2],
              ms[ms.size() * 99 / 100], ms.back());
  std::fflush(stdout);
}

/// False where a stop failed.
bool run(const std::string& dds, testing::Around around, unsigned tries) {
  testing::StopBench bench(dds, around);
  std::vector<double> ready;
  std::vector<double> command;
  unsigned failed = 0;
  const auto note = [&failed](const Result<Clock::Duration>& took, std::vector<double>& times) {
    if (took) return times.push_back(std::chrono::duration<double, std::milli>(*took).count());
    ++failed;
    std::fprintf(stderr, "%s\n", took.error().message.c_str());
  };
  for (unsigned i = 0; i < tries; ++i) {
    note(bench.stop(), ready);
    note(bench.stop_by_command(), command);
  }
  print(dds + ", " + testing::name_of(around) + ": as from the pages", ready);
  print(dds + ", " + testing::name_of(around) + ": `tonus stop`, start to end", command);
  return failed == 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Time from a request to stop until the rig's loop shows it.");
  unsigned tries = 200;
  std::string dds = "both";
  std::string role;
  int domain = 0;
  app.add_option("--tries", tries, "of each kind")->check(CLI::Range(1, 10000))->capture_default_str();
  app.add_option("--dds", dds, "vendor of the agent and the operator")
      ->check(CLI::IsMember({"fastdds", "cyclonedds", "both"}))
      ->capture_default_str();
  bool skips_full_spool = false;
  app.add_flag("--skip-full-spool", skips_full_spool, "it takes minutes to fill");
  app.add_option("--as", role, "the campaign's own: a process around the rig")->group("");
  app.add_option("--domain", domain, "of that process")->group("");
  CLI11_PARSE(app, argc, argv);
  try {
    if (!role.empty()) return testing::be(role, dds, domain);
    bool all_stopped = true;
    std::printf(
        "| vendor, around the rig | tries | median, ms | 99 %%, ms | worst, ms |\n|---|---|---|---|---|\n");
    for (const std::string vendor : {"fastdds", "cyclonedds"}) {
      if (dds != "both" && dds != vendor) continue;
      for (const auto around : testing::kAllAround) {
        if (skips_full_spool && around == testing::Around::kFullSpool) continue;
        all_stopped = run(vendor, around, tries) && all_stopped;
      }
    }
    return all_stopped ? 0 : 1;
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "rig_stop_campaign: %s\n", error.what()), 1;
  }
}
