#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "services/recording/recording.hpp"

namespace tonus::recording {

/// Reads an `_events.tsv` and sorts by onset. An event must lie within the record, to half a sample.
/// `onset` and `duration` are needed; a row without a trial number gets its place in the file, from 1.
[[nodiscard]] Result<std::vector<PerturbationEvent>> read_events(const std::filesystem::path& file,
                                                                 const Recording& recording);

/// A continuous perturbation over the whole record.
[[nodiscard]] PerturbationEvent whole_record(const Recording& recording, std::int64_t trial);

/// Content of an `_events.tsv`.
[[nodiscard]] std::string events_text(const std::vector<PerturbationEvent>& events);

/// Content of an `_events.json`: what the columns mean.
[[nodiscard]] std::string events_json();

}  // namespace tonus::recording
