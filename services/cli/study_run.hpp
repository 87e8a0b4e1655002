#pragma once

#include "services/cli/session_run.hpp"
#include "services/cli/system.hpp"
#include "services/scheduler/protocol.hpp"

namespace tonus::cli {

/// Runs every session of a study, one subject after the other, each with services of its own and the
/// simulated rig of this subject, all into one archive. `cohort` is the file of the subjects' profiles
/// (rig_agent/plant/cohort.hpp). The first session that does not complete is the error.
[[nodiscard]] Result<void> run_study(const SystemOptions& system, const RunOptions& run,
                                     const scheduler::Protocol& study, const std::string& cohort);

}  // namespace tonus::cli
