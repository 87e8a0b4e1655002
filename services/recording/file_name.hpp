#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "services/core/result.hpp"
#include "services/recording/recording.hpp"

namespace tonus::recording {

/// Takes a run's labels from the name of its `_motion.tsv`; a file without a run label is run 1.
/// kInvalidArgument: a part is not of the form entity-label, or sub, task or tracksys is missing.
[[nodiscard]] Result<void> take_labels(const std::filesystem::path& motion_file, Recording& recording);

/// Folder of the run's files below the dataset's root: "sub-01/ses-01/motion".
[[nodiscard]] std::filesystem::path run_folder(const Recording& recording);

/// Start of the run's file names, "sub-01_ses-01_task-unloaded_tracksys-manipulandum_acq-reference_run-01";
/// without the tracking system where `with_tracking_system` is false. kInvalidArgument: a label is empty or
/// has other than letters and digits.
[[nodiscard]] Result<std::string> run_stem(const Recording& recording, bool with_tracking_system = true);

/// A label of BIDS, which has letters and digits only, for a name. Distinct names have distinct labels: where
/// anything is left out, "x" and a checksum of the name follow. Empty for an empty name alone.
[[nodiscard]] std::string to_label(std::string_view name);

}  // namespace tonus::recording
