#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "services/cli/answer.hpp"
#include "services/cli/archive_option.hpp"
#include "services/cli/people_options.hpp"
#include "services/cli/session_client.hpp"
#include "services/core/result.hpp"
#include "services/simulation/profile.hpp"

namespace tonus::cli {

struct RunOptions {
  std::string protocol;  ///< TOML file of the protocol.
  std::string dataset;   ///< Or: play every record of this dataset.
  std::string subject = "sub-01";
  PeopleOptions people;
  std::uint64_t seed = 1;
  std::string profile;                         ///< Of the simulated rig, for the truth beside the results.
  std::string json;                            ///< File for the results; empty: none, "-": standard output.
  std::shared_ptr<const ResultsFile> results;  ///< Where that is.
  bool is_brief = false;  ///< Print one line at the end and no results: they are in the archive.
  bool is_dry = false;    ///< Say what would be done, and do nothing.
  std::string like;       ///< Dry run: an archived session that tells how many trials are expected.
  ArchiveOption archive;  ///< Where that session is.
  bool attaches = false;  ///< Watch the session that goes on, instead of starting one.
  /// Ctrl-C leaves the session to itself, and only a second one aborts it; else the first one does.
  bool detaches = false;
};

/// Runs one session from start to end with a progress bar, prints its results on standard output and writes
/// them to `json`. `tick` is called a few times a second and ends the run by an error; `interruptions` counts
/// how often Ctrl-C was pressed. What the session waits for, a held rig with what to type, is said at once.
[[nodiscard]] Result<void> run_session(SessionClient& client, const RunOptions& options, const Clock& clock,
                                       const std::function<Result<void>()>& tick,
                                       const std::function<int()>& interruptions);

/// Checks what the options say of subject, operator and study, before anything is asked of the services.
[[nodiscard]] Result<void> check_people(const RunOptions& options);

/// Reads the protocol that the options name.
[[nodiscard]] Result<std::string> protocol_text(const RunOptions& options);

}  // namespace tonus::cli
