#include "services/core/partial_folder.hpp"

#include <spdlog/fmt/fmt.h>
#include <unistd.h>
#include <utility>

namespace tonus {

namespace fs = std::filesystem;

Result<PartialEntry> PartialEntry::reserve(const fs::path& target) {
  std::error_code error;
  fs::path place = fs::absolute(target, error).lexically_normal();
  if (!place.has_filename()) place = place.parent_path();
  if (fs::exists(fs::symlink_status(place, error)))
    return fail(ErrorCode::kAlreadyExists,
                fmt::format("'{}': already exists; use a new path", target.string()));
  if (!fs::is_directory(place.parent_path(), error))
    return fail(ErrorCode::kNotFound, fmt::format("'{}': its parent folder does not exist", target.string()));
  PartialEntry entry(place.string() + fmt::format(".partial-{}", ::getpid()), place);
  fs::remove_all(entry.path_, error);  // left by a process of the same number that was killed
  return entry;
}

PartialEntry::PartialEntry(PartialEntry&& other) noexcept
    : path_(std::exchange(other.path_, {})), target_(std::move(other.target_)) {}

PartialEntry::~PartialEntry() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

Result<void> PartialEntry::finish() {
  std::error_code error;
  fs::rename(path_, target_, error);
  if (error) return fail(ErrorCode::kIo, target_.string() + ": cannot be created: " + error.message());
  path_.clear();
  return {};
}

Result<PartialFolder> PartialFolder::begin(const fs::path& target) {
  TONUS_TRY_ASSIGN(auto entry, reserve(target));
  std::error_code error;
  fs::create_directory(entry.path(), error);
  if (error)
    return fail(ErrorCode::kIo, fmt::format("'{}': cannot be created: {}", target.string(), error.message()));
  return PartialFolder(std::move(entry));
}

Result<PartialFile> PartialFile::begin(const fs::path& target) {
  TONUS_TRY_ASSIGN(auto entry, reserve(target));
  return PartialFile(std::move(entry));
}

}  // namespace tonus
