#pragma once

#include <filesystem>

#include "services/core/progress.hpp"
#include "services/core/result.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::formats {

/// Writes a session as one XDF file, for what works on recordings of the Lab Streaming Layer.
///
/// - stream 1, "tonus motion", double64: one channel for each column of samples/trial-N.csv from the raw ones
///   to the commanded ones (csv_columns.hpp), with its unit; each sample with its acquisition stamp. Samples
///   that were not measured are left out.
/// - stream 2, "tonus events", string: "trial 3 begins", "trial 3 onset" with posture and direction, "trial 3
///   ends" with its verdict; "note by Ada on trial 3: TEXT" and "marker: TEXT" where the rig was heard.
///
/// Stamps are the rig's monotonic clock in s, never rewritten: on the rig's host the clock of LSL too. The
/// archive's comparisons of that clock with its own host's stand as clock offsets, so that readers which
/// apply them get that host's clock. A simulated or replayed rig has a clock of its own, which compares with
/// none; then there are no offsets, and the header says so.
///
/// kNotFound: no trial has samples. Other errors as export_csv(); a failure leaves nothing.
[[nodiscard]] Result<void> export_xdf(store::Store& store, const store::Session& session,
                                      const std::filesystem::path& file, const Progress& progress = {});

}  // namespace tonus::formats
