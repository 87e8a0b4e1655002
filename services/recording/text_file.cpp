#include "services/recording/text_file.hpp"

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace tonus::recording {
namespace {

class FileDescriptor {
 public:
  explicit FileDescriptor(int descriptor) : descriptor_(descriptor) {}
  ~FileDescriptor() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  [[nodiscard]] int get() const { return descriptor_; }
  [[nodiscard]] bool close() { return ::close(std::exchange(descriptor_, -1)) == 0; }

 private:
  int descriptor_;
};

Error io_error(const std::filesystem::path& path, const char* what) {
  const int reason = errno;
  const bool is_absent = reason == ENOENT || reason == ENOTDIR;
  return fail(is_absent ? ErrorCode::kNotFound : ErrorCode::kIo,
              path.string() + ": " + what + ": " + std::strerror(reason));
}

}  // namespace

Result<std::string> read_text(const std::filesystem::path& path) {
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) return io_error(path, "cannot be read");
  struct stat info {};
  if (::fstat(file.get(), &info) != 0) return io_error(path, "cannot be read");
  if (!S_ISREG(info.st_mode))
    return fail(ErrorCode::kIo, path.string() + ": cannot be read: not a regular file");
  std::string text(static_cast<std::size_t>(info.st_size), '\0');
  std::size_t filled = 0;
  while (filled < text.size()) {
    const ssize_t count = ::read(file.get(), text.data() + filled, text.size() - filled);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return io_error(path, "cannot be read");
    if (count == 0) break;
    filled += static_cast<std::size_t>(count);
  }
  text.resize(filled);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  return text;
}

Result<void> write_text(const std::filesystem::path& path, std::string_view text) {
  FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (file.get() < 0) return io_error(path, "cannot be created");
  while (!text.empty()) {
    const ssize_t count = ::write(file.get(), text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return io_error(path, "cannot be written");
    text.remove_prefix(static_cast<std::size_t>(count));
  }
  if (::fsync(file.get()) != 0 || !file.close()) return io_error(path, "cannot be written");
  return {};
}

void append_number(std::string& text, double value) {
  constexpr double kLargestWhole = 9007199254740992.0;  // 2^53: whole doubles below it are exact as integers
  std::array<char, 32> digits;
  const bool is_negative_zero = value == 0.0 && std::signbit(value);
  const bool is_whole = std::abs(value) < kLargestWhole && value == std::trunc(value) && !is_negative_zero;
  char* const limit = digits.data() + digits.size();
  const auto end = is_whole ? std::to_chars(digits.data(), limit, static_cast<std::int64_t>(value))
                            : std::to_chars(digits.data(), limit, value);
  text.append(digits.data(), end.ptr);
}

}  // namespace tonus::recording
