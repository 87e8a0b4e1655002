#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "services/recording/recording.hpp"

namespace tonus::recording {

/// Reads `participants.tsv`, by participant id. Only participant_id is needed. A number that is none is
/// refused; or, where `left_out` is given, not known, and a line there says so.
[[nodiscard]] Result<std::map<std::string, Participant>> read_participants(
    const std::filesystem::path& file, std::vector<std::string>* left_out = nullptr);

/// Content of `participants.tsv`: the columns of which something is known.
[[nodiscard]] std::string participants_text(const std::vector<Participant>& participants);

/// Content of `participants.json`: what those columns mean.
[[nodiscard]] std::string participants_json(const std::vector<Participant>& participants);

}  // namespace tonus::recording
