#include "services/core/partial_folder.hpp"

#include <spdlog/fmt/fmt.h>
#include <unistd.h>
#include <utility>

namespace tonus {

namespace fs = std::filesystem;

Result<PartialFolder> PartialFolder::begin(const fs::path& target) {
  std::error_code error;
  fs::path place = fs::absolute(target, error).lexically_normal();
  if (!place.has_filename()) place = place.parent_path();
  if (fs::exists(fs::symlink_status(place, error)))
    return fail(ErrorCode::kAlreadyExists,
                fmt::format("'{}': already exists; use a new path", target.string()));
  if (!fs::is_directory(place.parent_path(), error))
    return fail(ErrorCode::kNotFound, fmt::format("'{}': its parent folder does not exist", target.string()));
  PartialFolder folder(place.string() + fmt::format(".partial-{}", ::getpid()), place);
  fs::remove_all(folder.path_, error);
  fs::create_directory(folder.path_, error);
  if (error) {
    return fail(ErrorCode::kIo, fmt::format("'{}': cannot be created: {}", target.string(), error.message()));
  }
  return folder;
}

PartialFolder::PartialFolder(PartialFolder&& other) noexcept
    : path_(std::exchange(other.path_, {})), target_(std::move(other.target_)) {}

PartialFolder::~PartialFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

Result<void> PartialFolder::finish() {
  std::error_code error;
  fs::rename(path_, target_, error);
  if (error) return fail(ErrorCode::kIo, target_.string() + ": cannot be created: " + error.message());
  path_.clear();
  return {};
}

}  // namespace tonus
