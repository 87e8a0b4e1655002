#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "services/core/file_descriptor.hpp"
#include "services/core/result.hpp"

namespace tonus::rig {

/// The folders in which a rig's programs keep what they must not lose, and the right to be the only program
/// that works with the rig: locks that end with the program however it ends.
///
/// Samples and trials belong to the experiment, <data>/rig/<name>. Calibration and hold belong to the rig:
/// whatever the data folder, they are in `own`. A rig that is simulated or replayed is a new one in each data
/// folder, and has all in one place.
class RigFolder {
 public:
  /// Makes the folders that are missing; an empty `own` is <data>/rig/<name>. kUnavailable where another
  /// program has one of them, or where `own` has no calibration and <data>/rig/<name> has one, of an earlier
  /// version: it is to be moved, and not to be forgotten. kInvalidArgument where the name is none
  /// (fault_of_name).
  [[nodiscard]] static Result<RigFolder> take(const std::filesystem::path& data, const std::string& name,
                                              const std::filesystem::path& own = {});

  [[nodiscard]] std::filesystem::path spool() const { return path_ / "spool"; }
  [[nodiscard]] std::filesystem::path trial_log() const { return path_ / "trials.log"; }
  [[nodiscard]] std::filesystem::path hold() const { return own_ / "hold"; }
  [[nodiscard]] std::filesystem::path calibration() const { return own_ / "calibration.toml"; }

 private:
  RigFolder() = default;
  [[nodiscard]] Result<void> lock(const std::filesystem::path& folder, const std::string& name);

  std::filesystem::path path_;
  std::filesystem::path own_;
  std::vector<FileDescriptor> locks_;
};

}  // namespace tonus::rig
