// A bare timer thread beside a rig, as a yardstick for its loop. Each line on standard input is answered with
// a line of JSON: cycles, missed periods, and the lateness histogram in the classes of rig/timing. Ends with
// standard input.
//
//   rig_bare_timer --rate 1000 --priority 80
#include "tests/bench/rig/bare_timer.hpp"

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <iostream>

int main(int argc, char** argv) {
  using namespace tonus;
  double rate = 1000.0;
  control::RealtimeRequest request;
  int priority = *request.fifo_priority;
  int cpu = -1;
  CLI::App app("A bare timer thread beside a rig.");
  app.add_option("--rate", rate, "periods a second")->check(CLI::Range(1.0, 10'000.0))->capture_default_str();
  app.add_option("--priority", priority, "SCHED_FIFO")->check(CLI::Range(1, 99))->capture_default_str();
  app.add_option("--cpu", cpu, "the one processor to run on; -1: any")->check(CLI::Range(-1, 1023));
  CLI11_PARSE(app, argc, argv);
  request.fifo_priority = priority;
  if (cpu >= 0) request.cpu = cpu;

  const BareTimer timer(std::llround(1e9 / rate), request);
  std::fprintf(stderr, "bare timer: %s\n", timer.statement().c_str());
  for (std::string line; std::getline(std::cin, line);) {
    const control::Pacer& pacer = timer.pacer();
    std::printf("{\"cycles\": %lu, \"missed_periods\": %lu, \"lateness_count\": [", pacer.cycles(),
                pacer.missed_periods());
    for (std::size_t i = 0; i < control::JitterHistogram::kClasses; ++i)
      std::printf("%s%lu", i == 0 ? "" : ", ", pacer.jitter().count(i));
    std::printf("]}\n");
    std::fflush(stdout);
  }
}
