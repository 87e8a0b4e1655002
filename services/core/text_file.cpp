#include "services/core/text_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace tonus {
namespace {

// Of these, where one is false, errno has the reason.

bool write_all(const FileDescriptor& file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(file.get(), text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return false;
    text.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

/// Makes a new file whose content is on the disk.
bool create_durably(const std::filesystem::path& path, std::string_view text) {
  FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  return file.is_open() && write_all(file, text) && ::fsync(file.get()) == 0 && file.close();
}

/// Into what is there. A pipe that nobody reads is not waited for.
bool write_through(const std::filesystem::path& path, std::string_view text) {
  FileDescriptor file(::open(path.c_str(), O_WRONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  const bool waits = file.is_open() && ::fcntl(file.get(), F_SETFL, 0) == 0;
  return waits && write_all(file, text) && file.close();
}

bool replace(const std::filesystem::path& path, std::string_view text) {
  auto fresh = path;
  fresh += fmt::format(".{}.new", getpid());
  ::unlink(fresh.c_str());  // left by a process of the same number that was killed
  if (create_durably(fresh, text) && std::rename(fresh.c_str(), path.c_str()) == 0) return true;
  const int reason = errno;
  ::unlink(fresh.c_str());
  errno = reason;
  return false;
}

/// A name of the system's, not of a file: /dev/stdout is the caller's output even where that is a file.
bool is_of_the_system(const std::filesystem::path& path) {
  const std::string& text = path.native();
  return text.starts_with("/dev/") || text.starts_with("/proc/");
}

}  // namespace

Error file_error(const std::filesystem::path& path, std::string_view what) {
  const int reason = errno;
  struct stat info {};
  const bool says_absent = reason == ENOENT || reason == ENOTDIR;
  const bool is_absent = says_absent && ::lstat(path.c_str(), &info) != 0;  // else a link to nothing
  return fail(is_absent ? ErrorCode::kNotFound : ErrorCode::kIo,
              fmt::format("{}: {}: {}", path.string(), what, std::strerror(reason)));
}

Result<RegularFile> open_for_reading(const std::filesystem::path& path) {
  FileDescriptor descriptor(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  struct stat info {};
  if (!descriptor.is_open() || ::fstat(descriptor.get(), &info) != 0)
    return file_error(path, "cannot be read");
  if (!S_ISREG(info.st_mode))
    return fail(ErrorCode::kIo, fmt::format("{}: cannot be read: not a regular file", path.string()));
  return RegularFile{std::move(descriptor), static_cast<std::size_t>(info.st_size)};
}

Result<std::string> read_text_file(const std::filesystem::path& path, std::size_t most) {
  const auto file = open_for_reading(path);
  if (!file) return file.error();
  const auto too_large = [&](std::size_t size) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("{}: {} bytes are not allowed; expected at most {}", path.string(), size, most));
  };
  if (file->size > most) return too_large(file->size);
  std::string text(file->size + 1, '\0');  // one more: the end is seen without another buffer
  std::size_t filled = 0;
  while (true) {
    if (filled > most) return too_large(filled);
    if (filled == text.size()) text.resize(2 * text.size());  // it grew meanwhile
    const ssize_t count = ::read(file->descriptor.get(), text.data() + filled, text.size() - filled);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return file_error(path, "cannot be read");
    if (count == 0) break;
    filled += static_cast<std::size_t>(count);
  }
  text.resize(filled);
  return text;
}

Result<void> create_text_file(const std::filesystem::path& path, std::string_view text) {
  if (!create_durably(path, text)) return file_error(path, "cannot be written");
  return {};
}

Result<void> write_text_file(const std::filesystem::path& path, std::string_view text) {
  struct stat info {};
  const bool is_there = ::stat(path.c_str(), &info) == 0;
  const bool is_regular = !is_there || S_ISREG(info.st_mode);
  const bool is_link = ::lstat(path.c_str(), &info) == 0 && S_ISLNK(info.st_mode);
  const bool is_special = !is_regular || (is_link && is_of_the_system(path));
  bool is_written = false;
  if (is_special) {
    is_written = write_through(path, text);
  } else if (!is_link) {
    is_written = replace(path, text);
  } else if (char* target = ::realpath(path.c_str(), nullptr); target != nullptr) {
    is_written = replace(target, text);
    std::free(target);
  }
  if (!is_written) return file_error(path, "cannot be written");
  return {};
}

}  // namespace tonus
