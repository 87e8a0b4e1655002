#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "services/core/result.hpp"

namespace tonus::recording {

/// The whole file, without a byte-order mark. kNotFound or kIo, with the path and the system's reason.
[[nodiscard]] Result<std::string> read_text(const std::filesystem::path& path);

/// Owns an open file of the system, or none (-1).
class FileDescriptor {
 public:
  explicit FileDescriptor(int descriptor) : descriptor_(descriptor) {}
  FileDescriptor(FileDescriptor&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&&) = delete;
  ~FileDescriptor() { (void)close(); }
  [[nodiscard]] int get() const { return descriptor_; }
  /// False: what was written may not be there. Nothing is owned afterwards.
  [[nodiscard]] bool close();

 private:
  int descriptor_;
};

/// A long text file, some whole lines at a time, without a byte-order mark.
class LineReader {
 public:
  /// kNotFound or kIo, with the path and the system's reason.
  [[nodiscard]] static Result<LineReader> open(const std::filesystem::path& path);
  /// Octets of the whole file, when it was opened.
  [[nodiscard]] std::size_t size() const { return size_; }

  /// The next lines, each with its end but for, perhaps, the file's last one; valid until the next call.
  /// Empty: that was all.
  [[nodiscard]] Result<std::string_view> next();

 private:
  LineReader(std::filesystem::path path, FileDescriptor file, std::size_t size);

  std::filesystem::path path_;
  FileDescriptor file_;
  std::size_t size_;
  std::string buffer_;
  std::size_t given_ = 0;   // octets of the buffer that have been handed out
  std::size_t filled_ = 0;  // octets of the buffer that the file has filled
  bool is_first_ = true;
};

/// Creates a file and waits until its content is on the disk. kIo.
[[nodiscard]] Result<void> write_text(const std::filesystem::path& path, std::string_view text);

/// Appends the shortest decimal text that reads back as the same double; whole numbers without exponent.
void append_number(std::string& text, double value);

}  // namespace tonus::recording
