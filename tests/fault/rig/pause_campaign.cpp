// rig_pause_campaign: random sets of a system's programs stand still for seconds; its sessions go on.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "tests/fault/rig/pause.hpp"

int main(int argc, char** argv) {
  using namespace tonus;
  CLI::App app("Pauses random sets of programs while sessions run in real time.", "rig_pause_campaign");
  testing::PauseCampaign campaign;
  campaign.prints_each = true;
  app.add_option("--pauses", campaign.pauses, "how many")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--seed", campaign.seed, "of sets and lengths")->capture_default_str();
  app.add_option("--dds", campaign.dds, "fastdds or cyclonedds")
      ->check(CLI::IsMember({"fastdds", "cyclonedds"}))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const auto report = testing::run_paused_sessions(campaign);
  if (!report) {
    std::fprintf(stderr, "rig_pause_campaign: %s\n", report.error().message.c_str());
    return 1;
  }
  std::printf("%s: %s", campaign.dds.c_str(), testing::text_of(*report).c_str());
  return report->late == 0 ? 0 : 1;
}
