#pragma once

#include <cstdint>
#include <string>

#include "services/core/result.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::dashboard {

/// What a page draws of archived trials: one trial and, as a comparison, up to eight that were run before it.
/// As JSON
///
///     {"displacement_unit": "m", "force_unit": "N", "courses": [{"attempt", "posture", "missing",
///      "times_s": [], "displacement": [[], []], "force": [[], []]}, ...]}
///
/// the wanted trial first, then the others, the nearest first. Times count from the onset, from 0.2 s before
/// to 1.2 s after it; displacements count from where the hand was at the onset; both vectors are in S
/// (one-axis rigs: the first component only). Displacement and force are in the units named. Of n samples in
/// that time every ceil(n/2000)th is given. Rows that the archive does not have, or that were marked as
/// missing, are left out and counted in "missing".
///
/// kNotFound: the session has no such trial, or the archive no onset of it. Trials before it that have none
/// are left out. Other errors: those of store::read_trial_samples() and store::rig_in_force() for the wanted
/// trial.
[[nodiscard]] Result<std::string> trial_courses(store::Store& store, const store::Session& session,
                                                std::uint32_t attempt);

}  // namespace tonus::dashboard
