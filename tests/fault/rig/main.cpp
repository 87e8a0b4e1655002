// rig_stall_campaign: a session in which everybody but the rig stands still for as long as is asked.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "tests/fault/rig/stall.hpp"
#include "tests/support/bus/private_network.hpp"

int main(int argc, char** argv) {
  using namespace tonus;
  CLI::App app("Stalls the services, or the bus, while the rig runs a session in real time.");
  unsigned seconds = 60;
  std::string what = "services";
  app.add_option("--seconds", seconds, "how long")->check(CLI::Range(1, 600))->capture_default_str();
  app.add_option("--stall", what, "services or bus")
      ->check(CLI::IsMember({"services", "bus"}))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const auto stall = what == "bus" ? testing::Stall::kBus : testing::Stall::kServices;
  if (stall == testing::Stall::kBus) {
    if (const auto entered = test::enter_private_network(); !entered) {
      std::fprintf(stderr, "rig_stall_campaign: %s\n", entered.error().message.c_str());
      return 1;
    }
  }
  std::printf("%u s of a session, then a stall of %u s, then its end ...\n", seconds, seconds);
  std::fflush(stdout);
  const auto report = testing::run_stalled_session(stall, seconds);
  if (!report) {
    std::fprintf(stderr, "rig_stall_campaign: %s\n", report.error().message.c_str());
    return 1;
  }
  std::printf("%s", testing::text_of(*report).c_str());
  const bool is_unharmed =
      report->dropped_samples == 0 && report->missing.empty() && report->faulted_trials == 0;
  return is_unharmed ? 0 : 1;
}
