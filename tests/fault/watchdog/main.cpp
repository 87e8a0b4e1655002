// watchdog_campaign: how long until the torque is off when the rig agent is killed or stopped.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <vector>

#include "tests/fault/watchdog/watched_agent.hpp"

namespace {

using tonus::testing::monotonic_ns;
using tonus::testing::WatchedAgent;

/// Lateness of a bare timer of 4 ms, in the same minutes: what this machine does to any program.
std::int64_t lateness_of_a_bare_timer() {
  const std::int64_t due = monotonic_ns() + 4'000'000;
  const timespec rest{0, 4'000'000};
  nanosleep(&rest, nullptr);
  return monotonic_ns() - due;
}

void print(const char* what, std::vector<std::int64_t> times) {
  std::sort(times.begin(), times.end());
  const auto ms = [&times](std::size_t i) { return 1e-6 * static_cast<double>(times[i]); };
  std::printf("| %s | %zu | %.1f | %.1f | %.1f |\n", what, times.size(), ms(times.size() / 2),
              ms(times.size() * 99 / 100), ms(times.size() - 1));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Time from the end or the standstill of the rig agent to no torque.");
  int tries = 100;
  app.add_option("--tries", tries, "of each kind")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  std::vector<std::int64_t> killed;
  std::vector<std::int64_t> stopped;
  std::vector<std::int64_t> bare;
  int failed = 0;
  for (int i = 0; i < 2 * tries; ++i) {
    const bool is_kill = i % 2 == 0;
    WatchedAgent agent;
    const std::int64_t begun = monotonic_ns();
    kill(agent.process().id(), is_kill ? SIGKILL : SIGSTOP);
    const std::int64_t took = agent.time_to_off(begun, std::chrono::seconds(10));
    kill(agent.process().id(), SIGKILL);
    (void)agent.process().wait(std::chrono::seconds(10));
    if (took < 0) ++failed;
    (is_kill ? killed : stopped).push_back(took);
    for (int k = 0; k < 10; ++k) bare.push_back(lateness_of_a_bare_timer());
    if (i % 20 == 19) std::fprintf(stderr, "%d of %d\n", i + 1, 2 * tries);
  }
  std::printf("| | tries | median, ms | 99 %%, ms | worst, ms |\n|---|---|---|---|---|\n");
  print("SIGKILL to torque off", killed);
  print("SIGSTOP to torque off", stopped);
  print("lateness of a bare timer", bare);
  std::printf("%d of %d without an end of the torque\n", failed, 2 * tries);
  return failed == 0 ? 0 : 1;
}
