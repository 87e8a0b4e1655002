#include "services/core/record_storage.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace tonus {
namespace {

/// Makes the file's entry in its folder durable.
int sync_folder(const std::filesystem::path& file) {
  const FileDescriptor folder(::open(file.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return folder.is_open() ? ::fsync(folder.get()) : -1;
}

int flags_of(FileStorage::Mode mode) {
  const int flags = O_RDWR | O_CLOEXEC;
  switch (mode) {
    case FileStorage::Mode::kCreate:
      return flags | O_CREAT | O_EXCL;
    case FileStorage::Mode::kOpen:
      return flags;
    case FileStorage::Mode::kOpenOrCreate:
      return flags | O_CREAT;
  }
  return flags;
}

}  // namespace

Result<std::unique_ptr<FileStorage>> FileStorage::open(const std::filesystem::path& path, Mode mode) {
  FileDescriptor descriptor(::open(path.c_str(), flags_of(mode), 0644));
  if (!descriptor.is_open()) {
    const ErrorCode code = errno == EEXIST                                  ? ErrorCode::kAlreadyExists
                           : errno == ENOENT && mode != Mode::kOpenOrCreate ? ErrorCode::kNotFound
                                                                            : ErrorCode::kIo;
    return fail(code, fmt::format("{}: cannot be opened: {}", path.string(), std::strerror(errno)));
  }
  std::unique_ptr<FileStorage> storage(new FileStorage(std::move(descriptor), path));
  if (mode != Mode::kOpenOrCreate && ::flock(storage->descriptor_.get(), LOCK_EX | LOCK_NB) != 0)
    return fail(ErrorCode::kUnavailable, fmt::format("{}: another program has it open", path.string()));
  if (mode == Mode::kCreate && sync_folder(path) != 0) return storage->error("its folder cannot be synced");
  return storage;
}

Error FileStorage::error(const char* what) const {
  return fail(ErrorCode::kIo, fmt::format("{}: {}: {}", path_.string(), what, std::strerror(errno)));
}

Result<std::uint64_t> FileStorage::size() const {
  struct stat status {};
  if (::fstat(descriptor_.get(), &status) != 0) return error("cannot be examined");
  return static_cast<std::uint64_t>(status.st_size);
}

Result<void> FileStorage::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  while (!bytes.empty()) {
    const ssize_t got = ::pread(descriptor_.get(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return error("cannot be read");
    if (got == 0)
      return fail(ErrorCode::kDataLoss, fmt::format("{}: ends at byte {}", path_.string(), offset));
    offset += static_cast<std::uint64_t>(got);
    bytes = bytes.subspan(static_cast<std::size_t>(got));
  }
  return {};
}

Result<void> FileStorage::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::pwrite(descriptor_.get(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return error("cannot be written");
    offset += static_cast<std::uint64_t>(put);
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
  return {};
}

Result<void> FileStorage::sync() {
  if (::fdatasync(descriptor_.get()) != 0) return error("cannot be synced");
  return {};
}

Result<void> FileStorage::truncate(std::uint64_t size) {
  if (::ftruncate(descriptor_.get(), static_cast<off_t>(size)) != 0) return error("cannot be cut");
  return {};
}

Result<void> FileStorage::rename_to(const std::filesystem::path& path) {
  if (std::rename(path_.c_str(), path.c_str()) != 0) return error("cannot be renamed");
  path_ = path;
  return {};
}

}  // namespace tonus
