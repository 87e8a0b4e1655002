#pragma once

#include <cstdint>
#include <vector>

#include "analysis_service/study/study.hpp"
#include "services/core/result.hpp"
#include "services/simulation/cohort.hpp"

namespace tonus::testing {

/// The unloaded experiment on every subject of a cohort: the realtime loop on the simulated rig within this
/// process, without bus and services, on all processors. Each posture is identified by the three published
/// methods. Noise is drawn from `seed`; the same seed gives the same study.
[[nodiscard]] Result<study::Study> simulate_cohort(const std::vector<simulation::CohortSubject>& cohort,
                                                   std::uint64_t seed);

}  // namespace tonus::testing
