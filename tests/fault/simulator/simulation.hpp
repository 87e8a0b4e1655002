#pragma once

#include <cstdint>
#include <string>

#include "services/core/result.hpp"
#include "tests/fault/scenario/scenario.hpp"

namespace tonus::simulator {

struct SimulationOptions {
  std::uint64_t seed = 1;  ///< Of everything that is drawn but the scenario.
  int trials = 8;          ///< Planned.
  bool is_quiet = true;    ///< False: the programs' log goes to standard error, with the simulated time.
};

struct Outcome {
  std::string broken;      ///< Invariants that did not hold, one a line; empty: all held.
  std::uint64_t hash = 0;  ///< Of every message, its time and its writer.
  unsigned trials = 0;     ///< Counted.
  double simulated = 0.0;  ///< s.
};

/// Runs one session of the whole system in this thread: the rig agent's loop, publisher and stop channel on
/// the simulated rig, scheduler, identification and archive as their programs wire them, an operator, a
/// network and disks. Programs that die or end are started anew. The same seed, scenario and trials give the
/// same hash.
///
/// Held against every run: no trial begins without an operator's word after what takes it back, or while the
/// rig is held; a hold and a death under power are still known after the next start; no receipt is given for
/// samples that are not stored; the session ends; every planned trial is counted once; every sample that was
/// published is stored as it was sent; verification finds all well.
///
/// Works in the folder "world" of the working folder, which should be in memory; whatever is in it is
/// lost.
[[nodiscard]] Outcome simulate(const testing::Scenario& scenario, const SimulationOptions& options);

}  // namespace tonus::simulator
