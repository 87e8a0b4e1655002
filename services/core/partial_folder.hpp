#pragma once

#include <filesystem>

#include "services/core/result.hpp"

namespace tonus {

/// What is made whole or not at all: filled under another name beside its place, and renamed at the end.
/// Unless it is finished it is removed with all that is in it.
class PartialEntry {
 public:
  PartialEntry(PartialEntry&& other) noexcept;
  PartialEntry& operator=(PartialEntry&&) = delete;
  ~PartialEntry();

  /// Where it is filled.
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// kIo: it could not be renamed, and is removed.
  [[nodiscard]] Result<void> finish();

 protected:
  /// Reserves the place; kAlreadyExists where `target` is there, also as a link to nothing; kNotFound where
  /// the folder that it belongs in is not.
  [[nodiscard]] static Result<PartialEntry> reserve(const std::filesystem::path& target);

 private:
  PartialEntry(std::filesystem::path path, std::filesystem::path target)
      : path_(std::move(path)), target_(std::move(target)) {}

  std::filesystem::path path_;  ///< Empty: nothing to remove.
  std::filesystem::path target_;
};

class PartialFolder : public PartialEntry {
 public:
  /// As reserve(), and makes the folder; kIo.
  [[nodiscard]] static Result<PartialFolder> begin(const std::filesystem::path& target);

 private:
  explicit PartialFolder(PartialEntry entry) : PartialEntry(std::move(entry)) {}
};

/// The caller makes the file at path().
class PartialFile : public PartialEntry {
 public:
  /// As reserve().
  [[nodiscard]] static Result<PartialFile> begin(const std::filesystem::path& target);

 private:
  explicit PartialFile(PartialEntry entry) : PartialEntry(std::move(entry)) {}
};

}  // namespace tonus
