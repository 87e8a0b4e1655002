#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "services/recording/channels.hpp"
#include "services/recording/recording.hpp"

namespace tonus::recording {

/// Reads a `_motion.tsv`, which has no header, into the recording's rows. A row with n/a, or `missing_value`
/// (MissingValues of `_motion.json`; empty: none), in any measured column that is used is missing.
/// kInvalidArgument: another number of cells than columns, a cell that is neither a finite number nor n/a, no
/// row at all, or time stamps (LATENCY) that do not fit the recording's rate.
[[nodiscard]] Result<void> read_rows(const std::filesystem::path& file, const Columns& columns,
                                     const std::string& missing_value, Recording& recording);

/// Content of a `_motion.tsv` with the channels that channels_of() names.
[[nodiscard]] std::string rows_text(const Recording& recording, bool with_converted);

}  // namespace tonus::recording
