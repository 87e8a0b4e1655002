#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "services/core/result.hpp"
#include "services/core/text_file.hpp"

namespace tonus::recording {

/// A long text file, some whole lines at a time, without a byte-order mark.
class LineReader {
 public:
  /// kNotFound or kIo, with the path and the system's reason.
  [[nodiscard]] static Result<LineReader> open(const std::filesystem::path& path);
  /// Octets of the whole file, when it was opened.
  [[nodiscard]] std::size_t size() const { return file_.size; }

  /// The next lines, each with its end but for, perhaps, the file's last one; valid until the next call.
  /// Empty: that was all.
  [[nodiscard]] Result<std::string_view> next();

 private:
  LineReader(std::filesystem::path path, RegularFile file);

  std::filesystem::path path_;
  RegularFile file_;
  std::string buffer_;
  std::size_t given_ = 0;   // bytes of the buffer that have been handed out
  std::size_t filled_ = 0;  // bytes of the buffer that the file has filled
  bool is_first_ = true;
};

/// The whole of a short text file, without a byte-order mark. Errors as LineReader.
[[nodiscard]] Result<std::string> read_unmarked(const std::filesystem::path& path);

}  // namespace tonus::recording
