#include "services/scheduler/journal_storage.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/file.h>
#include <unistd.h>
#include <utility>

namespace tonus::scheduler {
namespace {

/// Makes the file's entry in its folder durable.
int sync_folder(const std::filesystem::path& file) {
  const FileDescriptor folder(::open(file.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return folder.is_open() ? ::fsync(folder.get()) : -1;
}

}  // namespace

Result<std::unique_ptr<FileStorage>> FileStorage::open(const std::filesystem::path& file, Mode mode) {
  const int flags = O_RDWR | O_APPEND | O_CLOEXEC | (mode == Mode::kCreate ? O_CREAT | O_EXCL : 0);
  FileDescriptor descriptor(::open(file.c_str(), flags, 0644));
  if (!descriptor.is_open()) {
    const ErrorCode code = errno == EEXIST   ? ErrorCode::kAlreadyExists
                           : errno == ENOENT ? ErrorCode::kNotFound
                                             : ErrorCode::kIo;
    return fail(code, fmt::format("{}: cannot be opened: {}", file.string(), std::strerror(errno)));
  }
  std::unique_ptr<FileStorage> storage(new FileStorage(std::move(descriptor), file));
  if (::flock(storage->descriptor_.get(), LOCK_EX | LOCK_NB) != 0) {
    return fail(ErrorCode::kUnavailable, fmt::format("{}: another scheduler has it open", file.string()));
  }
  if (mode == Mode::kCreate && sync_folder(file) != 0) return storage->error("folder cannot be synced");
  return storage;
}

Error FileStorage::error(const char* action) const {
  return fail(ErrorCode::kIo, fmt::format("{}: {}: {}", file_.string(), action, std::strerror(errno)));
}

Result<std::string> FileStorage::read_all() {
  std::string octets;
  char part[65536];
  while (true) {
    const ssize_t got = ::pread(descriptor_.get(), part, sizeof part, static_cast<off_t>(octets.size()));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return error("cannot be read");
    if (got == 0) return octets;
    octets.append(part, static_cast<std::size_t>(got));
  }
}

Result<void> FileStorage::append(std::string_view octets) {
  while (!octets.empty()) {
    const ssize_t put = ::write(descriptor_.get(), octets.data(), octets.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return error("cannot be written");
    octets.remove_prefix(static_cast<std::size_t>(put));
  }
  return {};
}

Result<void> FileStorage::sync() {
  if (::fdatasync(descriptor_.get()) != 0) return error("cannot be synced");
  return {};
}

Result<void> FileStorage::truncate(std::size_t size) {
  if (::ftruncate(descriptor_.get(), static_cast<off_t>(size)) != 0) return error("cannot be cut");
  return sync();
}

}  // namespace tonus::scheduler
