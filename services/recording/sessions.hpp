#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "services/recording/recording.hpp"

/// The `_sessions.tsv` of a participant, `sub-01/sub-01_sessions.tsv`: a row a session.
namespace tonus::recording {

[[nodiscard]] std::filesystem::path sessions_file(const std::filesystem::path& root,
                                                  const std::string& participant);

/// By session, "ses-01"; empty where there is no such file. kInvalidArgument names the cell that is not
/// allowed. Columns of others, and columns that are not there, are left out.
[[nodiscard]] Result<std::map<std::string, SessionFacts>> read_sessions(const std::filesystem::path& file);

/// Writes the files of all participants of whose sessions something is known.
[[nodiscard]] Result<void> write_sessions(const std::filesystem::path& root,
                                          const std::vector<Recording>& recordings);

}  // namespace tonus::recording
