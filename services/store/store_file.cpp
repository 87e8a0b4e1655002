#include "services/store/store_file.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>
#include <unistd.h>

#include "services/core/file_descriptor.hpp"

namespace tonus::store {
namespace {

namespace fs = std::filesystem;

Error refuse(ErrorCode code, const std::string& target, const std::string& why) {
  return fail(code, fmt::format("'{}': {}", target, why));
}

void remove_with_logs(const std::string& path) {
  std::error_code ignored;
  for (const char* suffix : {"", "-journal", "-wal", "-shm"}) fs::remove(path + suffix, ignored);
}

/// Its name survives a loss of power.
void sync_folder_of(const fs::path& file) {
  std::error_code error;
  const auto folder = fs::absolute(file, error).parent_path();
  const FileDescriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor.get() >= 0) static_cast<void>(::fsync(descriptor.get()));
}

Result<void> rename_durably(const std::string& from, const std::string& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0) {
    const std::string why = std::strerror(errno);
    remove_with_logs(from);
    return refuse(ErrorCode::kIo, to, why);
  }
  sync_folder_of(to);
  return {};
}

/// The owner needs to be set only where another user replaces the file, who may or may not be allowed to.
bool take_owner_and_permissions(const std::string& from, const std::string& to) {
  struct stat old {};
  struct stat fresh {};
  if (::stat(from.c_str(), &old) != 0 || ::stat(to.c_str(), &fresh) != 0) return false;
  const bool is_same = old.st_uid == fresh.st_uid && old.st_gid == fresh.st_gid;
  if (!is_same && ::chown(to.c_str(), old.st_uid, old.st_gid) != 0) return false;
  return ::chmod(to.c_str(), old.st_mode & 07777U) == 0;
}

}  // namespace

Result<void> make_store_file(const std::string& target,
                             const std::function<Result<void>(const std::string& partial)>& make) {
  std::error_code error;
  for (const char* suffix : {"", "-wal", "-journal"}) {
    if (fs::exists(fs::symlink_status(target + suffix, error)))
      return refuse(ErrorCode::kAlreadyExists, target + suffix,
                    "already exists; expected the name of a new file, and no log beside it");
  }
  const std::string partial = target + ".partial";
  remove_with_logs(partial);  // of a run that was killed
  auto made = make(partial);
  if (made) return rename_durably(partial, target);
  remove_with_logs(partial);
  return made;
}

Result<void> replace_store_file(const std::string& path, const std::string& by) {
  if (take_owner_and_permissions(path, by)) return rename_durably(by, path);
  const std::string why = std::strerror(errno);
  remove_with_logs(by);
  return refuse(ErrorCode::kIo, path, fmt::format("its owner and permissions cannot be kept: {}", why));
}

}  // namespace tonus::store
