#pragma once

#include "services/cli/session_run.hpp"

namespace tonus::cli {

/// `tonus run --dry-run`: prints the trials of a protocol, its estimated duration, and the extremes of
/// workspace and force against the limits of the simulated rig (of `options.profile`, or the default one).
/// Of a study, a line for each session. Nothing is started and nothing moves.
[[nodiscard]] Result<void> print_dry_run(const RunOptions& options);

}  // namespace tonus::cli
