#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "services/core/result.hpp"

namespace tonus {

/// Absent, unreachable and empty are three things: only where the system says that there is no such entry is
/// a file absent. A folder that may not be read, a link to nothing, a link that leads in circles and a server
/// that does not answer are errors, kIo, that name the path and the reason. Nothing here throws.

/// False where there is no such entry; true where there is one that can be reached.
[[nodiscard]] Result<bool> is_present(const std::filesystem::path& path);

/// The path from the root on. kIo where it is relative and the folder that this process is in has been
/// removed.
[[nodiscard]] Result<std::filesystem::path> absolute_path(const std::filesystem::path& path);

/// Paths of the entries of a folder, by name. kNotFound where it is absent.
[[nodiscard]] Result<std::vector<std::filesystem::path>> list_folder(const std::filesystem::path& folder);

/// A regular file below a folder.
struct FileBelow {
  std::filesystem::path path;
  std::string relative;  ///< To the folder, with '/'.
  std::uintmax_t bytes = 0;
  std::filesystem::file_time_type modified;
};

/// What is below a folder, at any depth, by path. Links to folders are not followed. What cannot be reached
/// does not hide the rest.
struct FilesBelow {
  std::vector<FileBelow> files;
  std::vector<Error> unreachable;
};
[[nodiscard]] FilesBelow files_below(const std::filesystem::path& folder);

}  // namespace tonus
