#include "services/recording/text_file.hpp"

#include <algorithm>
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

Error io_error(const std::filesystem::path& path, const char* what) {
  const int reason = errno;
  const bool is_absent = reason == ENOENT || reason == ENOTDIR;
  return fail(is_absent ? ErrorCode::kNotFound : ErrorCode::kIo,
              path.string() + ": " + what + ": " + std::strerror(reason));
}

}  // namespace

Result<std::string> read_text(const std::filesystem::path& path) {
  auto file = LineReader::open(path);
  if (!file) return file.error();
  std::string text;
  text.reserve(file->size());
  while (true) {
    const auto lines = file->next();
    if (!lines) return lines.error();
    if (lines->empty()) return text;
    text += *lines;
  }
}

bool FileDescriptor::close() { return descriptor_ < 0 || ::close(std::exchange(descriptor_, -1)) == 0; }

LineReader::LineReader(std::filesystem::path path, FileDescriptor file, std::size_t size)
    : path_(std::move(path)), file_(std::move(file)), size_(size) {
  constexpr std::size_t kBuffer = 256 * 1024;  // stays in a processor's cache
  buffer_.resize(std::min(kBuffer, size + 1));
}

Result<LineReader> LineReader::open(const std::filesystem::path& path) {
  FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) return io_error(path, "cannot be read");
  struct stat info {};
  if (::fstat(file.get(), &info) != 0) return io_error(path, "cannot be read");
  if (!S_ISREG(info.st_mode))
    return fail(ErrorCode::kIo, path.string() + ": cannot be read: not a regular file");
  return LineReader(path, std::move(file), static_cast<std::size_t>(info.st_size));
}

Result<std::string_view> LineReader::next() {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  std::memmove(buffer_.data(), buffer_.data() + given_, filled_ - given_);
  filled_ -= given_;
  given_ = 0;
  while (true) {
    if (filled_ == buffer_.size()) buffer_.resize(2 * buffer_.size());  // a line longer than the buffer
    const ssize_t count = ::read(file_.get(), buffer_.data() + filled_, buffer_.size() - filled_);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return io_error(path_, "cannot be read");
    const bool is_end = count == 0;
    filled_ += static_cast<std::size_t>(count);
    const std::string_view text(buffer_.data(), filled_);
    given_ = is_end ? filled_ : text.rfind('\n') + 1;  // npos + 1 is 0
    if (given_ == 0 && !is_end) continue;
    const bool is_marked = std::exchange(is_first_, false) && text.starts_with(kByteOrderMark);
    return text.substr(0, given_).substr(is_marked ? kByteOrderMark.size() : 0);
  }
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
