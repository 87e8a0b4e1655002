// scheduler-kills: sessions whose scheduler is ended with SIGKILL at random moments.

#include <CLI/CLI.hpp>
#include <cstdio>

#include "tests/fault/scheduler/kill_campaign.hpp"
#include "tests/support/process.hpp"

int main(int argc, char** argv) {
  using namespace tonus::testing;
  unsigned sessions = 200;
  std::uint64_t seed = 1;
  CLI::App app("Sessions whose scheduler is killed at random moments; each must end with every trial once.",
               "scheduler-kills");
  app.add_option("--sessions", sessions, "how many")->capture_default_str()->check(CLI::Range(1U, 100000U));
  app.add_option("--seed", seed, "of the first session; each further one has the next")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);

  unsigned kills = 0;
  unsigned failures = 0;
  for (unsigned i = 0; i < sessions; ++i) {
    const auto run = run_killed_session(source_file("deploy/protocols/unloaded.toml"), seed + i);
    if (!run) {
      ++failures;
      std::printf("seed %llu: %s\n", static_cast<unsigned long long>(seed + i), run.error().message.c_str());
    } else {
      kills += run->kills;
    }
    if ((i + 1) % 10 == 0 || i + 1 == sessions) {
      std::printf("%u of %u sessions, %u kills, %u failures\n", i + 1, sessions, kills, failures);
    }
    std::fflush(stdout);
  }
  return failures == 0 && kills > 0 ? 0 : 1;
}
