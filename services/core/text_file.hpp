#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "services/core/file_descriptor.hpp"
#include "services/core/result.hpp"

namespace tonus {

/// What the system says (errno) about the file at `path`: kNotFound where there is no such entry, kIo
/// otherwise, also for a link to nothing.
/// `what` went wrong, such as "cannot be read".
[[nodiscard]] Error file_error(const std::filesystem::path& path, std::string_view what);

/// An ordinary file, open for reading.
struct RegularFile {
  FileDescriptor descriptor;
  std::size_t size;  ///< bytes when it was opened
};

/// As file_error(); kIo also for a folder, a device or a pipe, for which it does not wait.
[[nodiscard]] Result<RegularFile> open_for_reading(const std::filesystem::path& path);

/// What is read at once, at most, unless the caller says otherwise.
inline constexpr std::size_t kLargestText = std::size_t{256} << 20U;

/// The whole file, byte for byte. kNotFound or kIo names it and the reason; kInvalidArgument where it has
/// more than `most` bytes, before memory is taken for them.
[[nodiscard]] Result<std::string> read_text_file(const std::filesystem::path& path,
                                                 std::size_t most = kLargestText);

/// Makes a file that is not there yet and waits until its content is on the disk. kIo names it and the
/// reason.
[[nodiscard]] Result<void> create_text_file(const std::filesystem::path& path, std::string_view text);

/// Creates a file beside `path` and renames it: afterwards `path` is whole or as it was before. A link stays,
/// and the file that it leads to is replaced; into what is no file (a device, a pipe, /dev/stdout) the text
/// is written. kIo names the path and the reason.
[[nodiscard]] Result<void> write_text_file(const std::filesystem::path& path, std::string_view text);

}  // namespace tonus
