#pragma once

#include <filesystem>
#include <string>

#include "services/core/result.hpp"

namespace tonus::rig {

/// The folder in which a rig's programs keep what they must not lose, and the right to be the only program
/// that works with the rig: a lock that ends with the program however it ends.
class RigFolder {
 public:
  /// <data>/rig/<name>, made if it is missing. kUnavailable where another program has it. kInvalidArgument
  /// where the name is none (fault_of_name).
  [[nodiscard]] static Result<RigFolder> take(const std::filesystem::path& data, const std::string& name);

  RigFolder(RigFolder&& other) noexcept;
  RigFolder& operator=(RigFolder&&) = delete;
  ~RigFolder();

  [[nodiscard]] std::filesystem::path spool() const { return path_ / "spool"; }
  [[nodiscard]] std::filesystem::path trial_log() const { return path_ / "trials.log"; }
  [[nodiscard]] std::filesystem::path hold() const { return path_ / "hold"; }
  [[nodiscard]] std::filesystem::path calibration() const { return path_ / "calibration.toml"; }

 private:
  RigFolder(std::filesystem::path path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace tonus::rig
