#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "services/recording/recording.hpp"
#include "services/simulation/profile.hpp"

/// Sessions on the simulated rig within one process: the realtime loop over the simulated driver, stepped as
/// fast as it goes, without bus and services. What comes out is what an export of such a session holds.
namespace tonus::simulated {

struct Posture {
  std::string name;
  Eigen::Vector2d position;  ///< m, in S.
};

/// The five published positions: reference, distal, proximal, right, left.
[[nodiscard]] const std::vector<Posture>& published_postures();

/// The same for every perturbation of a posture. The defaults are the published unloaded ones, but for the
/// pauses between perturbations, which are short.
struct Procedure {
  int sets = 2;  ///< Of eight directions, 45 deg apart, the first along +x of S.
  double amplitude = 0.005;
  double rise_time = 0.2;
  double hold = 1.75;
  double centring_time = 0.3;
  double shortest_wait = 1.2;  ///< s before the onset; the waits are evenly spread up to the longest.
  double longest_wait = 1.2;
};

/// Measures one posture: all samples from the first trial's first to the last trial's last, raw counts and
/// volts, with their events. `first_trial` numbers the first perturbation. Deterministic from the profile's
/// seed. Errors: a loop or a trial that the rig's own validation refuses, a trial that is not completed.
[[nodiscard]] Result<recording::Recording> measure(const simulation::Profile& profile, const Posture& posture,
                                                   const Procedure& procedure = {},
                                                   std::int64_t first_trial = 1);

}  // namespace tonus::simulated
