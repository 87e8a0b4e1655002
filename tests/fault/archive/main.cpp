// Crashes archives, half of them by SIGKILL and half by a disk that fails, and checks after each crash that
// everything that a receipt was given for is there.

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "tests/fault/archive/crash_campaign.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using tonus::archive::testing::CrashCampaign;
using tonus::archive::testing::CrashCounts;

bool run(const char* name, CrashCampaign& campaign, std::uint64_t crashes) {
  const bool is_terminal = ::isatty(STDERR_FILENO) == 1;
  const auto started = std::chrono::steady_clock::now();
  for (std::uint64_t i = 0; i < crashes; ++i) {
    if (const auto good = campaign.crash(); !good) {
      fmt::print("\n{}: crash {}: {}\n", name, i + 1, good.error().message);
      return false;
    }
    if (is_terminal || (i + 1) % 50 == 0 || i + 1 == crashes) {
      fmt::print(stderr, "{}{}: {} of {} crashes, {} receipts held{}", is_terminal ? "\r" : "", name, i + 1,
                 crashes, campaign.counts().receipts, is_terminal ? "" : "\n");
    }
  }
  if (is_terminal) fmt::print(stderr, "\n");
  const CrashCounts& counts = campaign.counts();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  fmt::print(
      "{}: {} crashes in {} files, {:.0f} s; {} receipts for {} samples, all there; every file opened; "
      "{} died before their store was open; {} operations were refused before a loss of power\n",
      name, counts.crashes, counts.files, seconds, counts.receipts, counts.samples, counts.failed_starts,
      counts.disk_errors);
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Crashes archives and checks what they gave receipts for.", "archive_crash_campaign");
  std::uint64_t seed = 1;
  std::uint64_t crashes = 100;
  std::string kind = "both";
  std::string program = tonus::testing::program("tonus-archive").string();
  app.add_option("--seed", seed, "the same seed brings the same failures")->capture_default_str();
  app.add_option("--crashes", crashes, "of all kinds together")->capture_default_str();
  app.add_option("--kind", kind, "power: a disk that fails; kill: SIGKILL; both: half of each")
      ->check(CLI::IsMember({"power", "kill", "both"}))
      ->capture_default_str();
  app.add_option("--program", program, "tonus-archive that is killed")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const tonus::testing::TemporaryFolder folder;
  bool is_good = true;
  const std::uint64_t share = kind == "both" ? crashes / 2 : crashes;
  if (kind != "kill") {
    tonus::archive::testing::PowerLossCampaign campaign(folder.path(), seed);
    is_good = run("disk", campaign, crashes - (kind == "both" ? share : 0));
  }
  if (kind != "power" && is_good) {
    tonus::archive::testing::KillCampaign campaign(folder.path(), seed, program,
                                                   tonus::testing::own_domain());
    is_good = run("kill", campaign, share);
  }
  return is_good ? 0 : 1;
}
