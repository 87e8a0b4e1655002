// device_fault_campaign: faulty devices against a simulated hand, and what the loop made of them.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <vector>

#include "rig_agent/control/fault_text.hpp"
#include "tests/fault/driver/fault_campaign.hpp"

namespace tonus::testing {
namespace {

struct Row {
  int cases = 0;
  int found = 0;
  int harmless = 0;
  std::vector<int> detection;  // ms
  double way_beyond = -1.0;
  double force_share = 0.0;
  int under_torque = 0;
  std::set<std::string> names;
};

void print(DeviceFault fault, const Row& row) {
  auto sorted = row.detection;
  std::sort(sorted.begin(), sorted.end());
  const int median = sorted.empty() ? -1 : sorted[sorted.size() / 2];
  const int worst = sorted.empty() ? -1 : sorted.back();
  std::string names;
  for (const auto& name : row.names) names += (names.empty() ? "" : "; ") + name;
  std::printf("| %s | %d | %d | %d | %d / %d | %+.1f | %.2f | %d | %s |\n", name_of(fault), row.cases,
              row.found, row.harmless, median, worst, 1000.0 * row.way_beyond, row.force_share,
              row.under_torque, names.c_str());
}

// Sorted, the value at a share of the way.
double at(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void print_stops(int cases, std::uint64_t seed, std::optional<DeviceFault> fault, const Hardness& hardness,
                 bool is_verbose) {
  if (cases <= 0) return;
  int outside = 0;
  int dropped = 0;
  std::vector<double> put_in;
  std::vector<double> taken;
  std::vector<double> way;
  for (int i = 0; i < cases; ++i) {
    const StopCase seen = run_stop_case(seed + static_cast<std::uint64_t>(i), fault, hardness);
    put_in.push_back(seen.energy_put_in);
    taken.push_back(seen.energy_taken);
    way.push_back(1000.0 * seen.way_beyond);
    outside += seen.way_beyond > 0.0 ? 1 : 0;
    dropped += seen.speed_when_dropped > 0.02 ? 1 : 0;
    if (is_verbose)
      std::printf(
          "stop seed %lu: %.4f J at the stop, put in %.4f J, taken %.4f J, %+.1f mm, dropped at %.3f m/s "
          "after %d ms\n",
          seed + static_cast<std::uint64_t>(i), seen.energy_at_stop, seen.energy_put_in, seen.energy_taken,
          1000.0 * seen.way_beyond, seen.speed_when_dropped, seen.cycles_under_torque);
  }
  std::printf(
      "%d stops, %s: torque dropped above 2 cm/s %d; put in, mJ: 95 %% %.1f, worst %.1f; taken, mJ: mean "
      "%.2f; "
      "outside the workspace %d, worst %+.1f mm\n",
      cases, fault ? name_of(*fault) : "sound", dropped, 1000.0 * at(put_in, 0.95), 1000.0 * at(put_in, 1.0),
      1000.0 * std::accumulate(taken.begin(), taken.end(), 0.0) / cases, outside, at(way, 1.0));
}

}  // namespace
}  // namespace tonus::testing

int main(int argc, char** argv) {
  using namespace tonus::testing;
  CLI::App app("Faulty devices against a simulated hand: what the loop finds, and what the hand feels.");
  int cases = 500;
  int healthy_cases = 100;
  std::uint64_t seed = 1;
  bool is_verbose = false;
  app.add_option("--cases", cases, "faults to draw")->capture_default_str();
  app.add_option("--healthy", healthy_cases, "trials without a fault")->capture_default_str();
  Hardness hardness;
  app.add_option("--trials-after", hardness.trials_after,
                 "trials run on with a fault that its own did not show")
      ->capture_default_str();
  app.add_flag("--wrong-model", hardness.is_model_wrong,
               "the law's model is off by up to 15 % in inertia and a factor of 2 in friction");
  app.add_flag(
      "--other-rig", hardness.is_rig_other,
      "motors, friction and arm are sound, and far from what the law expects (for trials without a fault)");
  app.add_option("--seed", seed, "of the first one")->capture_default_str();
  int stops = 0;
  app.add_option("--stops", stops, "emergency stops, of a sound rig and of one with a reversed encoder")
      ->capture_default_str();
  app.add_flag("--verbose", is_verbose, "a line for each case");
  CLI11_PARSE(app, argc, argv);

  std::map<DeviceFault, Row> rows;
  int false_alarms = 0;
  int bad = 0;
  for (int i = 0; i < cases; ++i) {
    const FaultCase seen = run_fault_case(seed + static_cast<std::uint64_t>(i), hardness);
    Row& row = rows[seen.fault];
    ++row.cases;
    row.found += seen.found != 0 ? 1 : 0;
    row.harmless += seen.was_harmless ? 1 : 0;
    if (seen.found != 0) {
      row.detection.push_back(seen.cycles_to_detection);
      row.names.insert(tonus::control::fault_text(seen.found));
    }
    row.way_beyond = std::max(row.way_beyond, seen.way_beyond);
    row.force_share = std::max(row.force_share, seen.force_share);
    row.under_torque = std::max(row.under_torque, seen.cycles_under_torque);
    const bool is_bad = (seen.found == 0 && !seen.was_harmless) || seen.way_beyond > 0.005 ||
                        seen.force_share > 1.1 || seen.cycles_under_torque > 2;
    bad += is_bad ? 1 : 0;
    if (is_verbose || is_bad) {
      std::printf("%s seed %lu, %s, phase %s: found %s after %d ms, %+.1f mm, force %.2f, under torque %d\n",
                  is_bad ? "BAD" : "ok", seed + static_cast<std::uint64_t>(i), name_of(seen.fault),
                  tonus::control::phase_name(seen.phase), tonus::control::fault_text(seen.found).c_str(),
                  seen.cycles_to_detection, 1000.0 * seen.way_beyond, seen.force_share,
                  seen.cycles_under_torque);
    }
  }
  std::map<std::string, int> names;
  for (int i = 0; i < healthy_cases; ++i) {
    const auto found = run_healthy_case(seed + static_cast<std::uint64_t>(i), hardness);
    if (found == 0) continue;
    ++false_alarms;
    ++names[tonus::control::fault_text(found)];
    if (is_verbose || !hardness.is_rig_other)
      std::printf("FALSE ALARM seed %lu: %s\n", seed + static_cast<std::uint64_t>(i),
                  tonus::control::fault_text(found).c_str());
  }
  std::printf(
      "| fault | cases | found | harmless | found after, ms: median / worst | beyond the workspace, mm | "
      "force / limit | driven after, cycles | named |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& [fault, row] : rows) print(fault, row);
  for (const auto& [name, count] : names) std::printf("healthy, stopped: %s: %d\n", name.c_str(), count);
  print_stops(stops, seed, std::nullopt, hardness, is_verbose);
  print_stops(stops, seed, DeviceFault::kEncoderReversed, hardness, is_verbose);
  std::printf("%d cases, %d bad; %d healthy trials, %d false alarms\n", cases, bad, healthy_cases,
              false_alarms);
  return bad == 0 && false_alarms == 0 ? 0 : 1;
}
