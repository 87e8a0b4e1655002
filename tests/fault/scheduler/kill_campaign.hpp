#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "services/core/result.hpp"

namespace tonus::testing {

/// What one session of the campaign came to.
struct KilledSession {
  unsigned kills = 0;  ///< That hit a running scheduler.
  double first_kill_s = 0.0;
};

/// Runs one whole session of `protocol` in processes of its own, with a domain and a folder of its own, and
/// ends its scheduler with SIGKILL one to three times, at moments drawn from the seed. Afterwards:
///
/// - the session is complete and the command says so;
/// - the journal holds exactly the planned trials as counted, each once, and its end;
/// - the archive holds a valid verdict and a whole certificate for each of those trials, and of no other
/// trial
///   a valid verdict.
///
/// kInternal: one of these does not hold; the message says which.
[[nodiscard]] Result<KilledSession> run_killed_session(const std::filesystem::path& protocol,
                                                       std::uint64_t seed);

}  // namespace tonus::testing
