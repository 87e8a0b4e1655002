// bus_fuzz: mutated packets to every port, and mutated messages on every topic, of a whole running system.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <unistd.h>

#include "tests/fuzz/bus_attack.hpp"
#include "tests/support/bus/private_network.hpp"

int main(int argc, char** argv) {
  using namespace tonus;
  CLI::App app("Attacks the ports and topics of a running system, in a network of its own.", "bus_fuzz");
  fuzz::BusAttack attack;
  attack.shows_progress = ::isatty(STDERR_FILENO) == 1;
  app.add_option("--seed", attack.seed, "of the first input; the next one has the next")
      ->capture_default_str();
  app.add_option("--packets", attack.packets, "mutated RTPS packets")->capture_default_str();
  app.add_option("--messages", attack.messages, "mutated messages")->capture_default_str();
  app.add_option("--dds", attack.dds, "fastdds or cyclonedds")
      ->check(CLI::IsMember({"fastdds", "cyclonedds"}))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (const auto entered = test::enter_private_network(); !entered) {
    std::fprintf(stderr, "bus_fuzz: %s; skipped\n", entered.error().message.c_str());
    return 77;
  }
  const auto report = fuzz::attack_bus(attack);
  if (!report) {
    std::fprintf(stderr, "bus_fuzz: %s\n", report.error().message.c_str());
    return 1;
  }
  std::printf("%s: %s", attack.dds.c_str(), fuzz::text_of(*report).c_str());
  return 0;
}
