#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "services/core/progress.hpp"
#include "services/core/result.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::formats {

/// What is put beside an export: path below its folder, and content.
using FurtherFiles = std::vector<std::pair<std::string, std::string>>;

/// Writes a session as a folder of CSV files (RFC 4180, UTF-8, '.' as decimal sign, header line):
///
/// - columns.csv: every column of every file, with unit and meaning
/// - session.csv: one row: subject, operator, study, what is known of the subject
/// - notes.csv: one row a note or marker
/// - trials.csv: one row an attempt: what was planned, how it ended, its verdict and certificate
/// - estimates.csv: one row an element of a matrix or vector of each condition, method and model
/// - samples/trial-N.csv: one row a sample: raw and converted; empty cells where nothing was measured
///
/// A text that a spreadsheet would take for a formula has an apostrophe before it: '=1+1 instead of =1+1.
/// Numbers are the shortest text that reads back as the same double. `folder` must not exist; it is filled
/// under a temporary name beside its place and renamed at the end: a failure leaves nothing.
/// kAlreadyExists, kIo, and the store's errors; kNotFound where a rig description or the parent folder is
/// missing.
[[nodiscard]] Result<void> export_csv(store::Store& store, const store::Session& session,
                                      const std::filesystem::path& folder, const FurtherFiles& further = {},
                                      const Progress& progress = {});

}  // namespace tonus::formats
