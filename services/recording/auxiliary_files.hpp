#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/result.hpp"
#include "services/recording/recording.hpp"

/// Auxiliary channels of a recording, in files of their own beside the motion's: one for each rate. BIDS has
/// a file for each tracking system, of one rate and of motion's channel types, so that
///
///     sub-01_task-unloaded_tracksys-auxiliaryx2_run-01_motion.tsv
///
/// has two values for each row of ..._tracksys-manipulandum_..., its channels are of type MISC, and what they
/// are (EMG, TRIG, ...) stands in the column `description` of `_channels.tsv` and in `_channels.json`, with
/// the time of the first value from the recording's first row.
namespace tonus::recording {

/// One of those files, without its values.
struct AuxiliaryFile {
  std::filesystem::path motion_file;
  std::uint32_t values_per_row = 1;
  std::vector<AuxiliaryChannel> channels;  ///< In the order of the columns.
  std::vector<std::size_t> places;         ///< Of each among the recording's channels.
};

/// Values for each row that a tracking system of this label has; 0: it is not one of auxiliary channels.
[[nodiscard]] std::uint32_t auxiliary_values_of(std::string_view tracking_system);

/// What `_channels.tsv` and `_channels.json` say of the channels; `rate` of the recording, Hz.
/// kInvalidArgument names the file, the channel and what is allowed.
[[nodiscard]] Result<AuxiliaryFile> open_auxiliary(const std::filesystem::path& motion_file,
                                                   std::uint32_t values_per_row, double rate);

/// Reads the values of all of the recording's files, whose rows have been read; n/a is NaN. kInvalidArgument:
/// a cell that is neither a number nor n/a, another number of cells than channels, or of rows than the
/// recording needs; two channels of one name.
[[nodiscard]] Result<void> read_auxiliary(const std::vector<AuxiliaryFile>& files, Recording& recording);

/// Writes the recording's files into `folder`. Values are written so that they are read back as they were.
[[nodiscard]] Result<void> write_auxiliary(const std::filesystem::path& folder, const Recording& recording);

/// kInvalidArgument: channels that cannot be (validate(AuxiliaryChannel)), or another number of values than
/// the rows need.
[[nodiscard]] Result<void> check_auxiliary(const Recording& recording);

}  // namespace tonus::recording
