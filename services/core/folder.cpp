#include "services/core/folder.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <utility>

namespace tonus {
namespace {

namespace fs = std::filesystem;

Error unreachable(const fs::path& path, const std::error_code& reason) {
  return fail(ErrorCode::kIo, fmt::format("{}: cannot be reached: {}", path.string(), reason.message()));
}

bool says_absent(const std::error_code& error) {
  return error == std::errc::no_such_file_or_directory || error == std::errc::not_a_directory;
}

/// Below `folder`, which is `relative` to where the search began.
void search(const fs::path& folder, const std::string& relative, FilesBelow& below) {
  const auto entries = list_folder(folder);
  if (!entries) {
    below.unreachable.push_back(entries.error());
    return;
  }
  for (const fs::path& path : *entries) {
    const std::string name = relative + path.filename().string();
    std::error_code error;
    const fs::file_type type = fs::symlink_status(path, error).type();
    if (type == fs::file_type::not_found) continue;  // removed since it was listed
    if (type == fs::file_type::directory) {
      search(path, name + "/", below);
      continue;
    }
    const bool is_file = !error && fs::is_regular_file(path, error);
    FileBelow file{path, name, 0, {}};
    if (is_file) file.bytes = fs::file_size(path, error);
    if (is_file && !error) file.modified = fs::last_write_time(path, error);
    if (error) {
      below.unreachable.push_back(unreachable(path, error));
    } else if (is_file) {
      below.files.push_back(std::move(file));
    }
  }
}

}  // namespace

Result<fs::path> absolute_path(const fs::path& path) {
  std::error_code error;
  fs::path absolute = fs::absolute(path, error);
  if (error) {
    return fail(ErrorCode::kIo, fmt::format("{}: the folder that this command was started in is gone ({})",
                                            path.string(), error.message()));
  }
  return absolute;
}

Result<bool> is_present(const fs::path& path) {
  std::error_code error;
  const fs::file_status entry = fs::symlink_status(path, error);
  if (says_absent(error) || entry.type() == fs::file_type::not_found) {
    // Absent, unless the way to it leads over a link to nothing.
    const fs::path parent = path.parent_path();
    if (parent.empty() || parent == path) return false;
    if (const auto above = is_present(parent); !above) return above.error();
    return false;
  }
  if (error) return unreachable(path, error);
  if (entry.type() != fs::file_type::symlink) return true;
  const fs::file_status target = fs::status(path, error);
  if (target.type() == fs::file_type::not_found) {
    return fail(ErrorCode::kIo, fmt::format("{}: cannot be reached: is a link to '{}', which does not exist",
                                            path.string(), fs::read_symlink(path, error).string()));
  }
  if (error) return unreachable(path, error);
  return true;
}

Result<std::vector<fs::path>> list_folder(const fs::path& folder) {
  TONUS_TRY_ASSIGN(const bool is_there, is_present(folder));
  if (!is_there) return fail(ErrorCode::kNotFound, folder.string() + ": no such folder");
  std::vector<fs::path> paths;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    paths.push_back(entry->path());
  if (error) return fail(ErrorCode::kIo, folder.string() + ": cannot be listed: " + error.message());
  std::sort(paths.begin(), paths.end());
  return paths;
}

FilesBelow files_below(const fs::path& folder) {
  FilesBelow below;
  search(folder, "", below);
  return below;
}

}  // namespace tonus
