#pragma once

#include <filesystem>

#include "services/core/result.hpp"

namespace tonus {

/// A folder that is made whole or not at all: filled under another name beside its place, and renamed at the
/// end. Unless it is finished it is removed with all that is in it.
class PartialFolder {
 public:
  /// kAlreadyExists where `target` is there, also as a link to nothing; kNotFound where the folder that it
  /// belongs in is not; kIo.
  [[nodiscard]] static Result<PartialFolder> begin(const std::filesystem::path& target);

  PartialFolder(PartialFolder&& other) noexcept;
  PartialFolder& operator=(PartialFolder&&) = delete;
  ~PartialFolder();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] Result<void> finish();

 private:
  PartialFolder(std::filesystem::path path, std::filesystem::path target)
      : path_(std::move(path)), target_(std::move(target)) {}

  std::filesystem::path path_;  ///< Empty: nothing to remove.
  std::filesystem::path target_;
};

}  // namespace tonus
