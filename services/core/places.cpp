#include "services/core/places.hpp"

#include <cstdlib>
#include <spdlog/fmt/fmt.h>
#include <string_view>
#include <sys/stat.h>

#include "services/core/folder.hpp"

namespace tonus {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSystem = "/var/lib/tonus";
constexpr const char* kRemedy = "set HOME or XDG_DATA_HOME, or say --data FOLDER";

std::string_view variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

/// The variable's folder, which everybody may not write to.
Result<fs::path> private_folder(const char* name) {
  fs::path folder = variable(name);
  if (!folder.is_absolute()) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("{}: '{}' is not allowed; expected an absolute path ({})", name, folder.string(),
                            kRemedy));
  }
  struct stat info {};
  if (::stat(folder.c_str(), &info) == 0 && (info.st_mode & S_IWOTH) != 0) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("{}: '{}' is not allowed; expected a folder that not everybody may write to ({})",
                            name, folder.string(), kRemedy));
  }
  return folder;
}

/// The folder that the variables name.
Result<fs::path> folder_of_user() {
  if (!variable("XDG_DATA_HOME").empty()) {
    TONUS_TRY_ASSIGN(const fs::path folder, private_folder("XDG_DATA_HOME"));
    return folder / "tonus";
  }
  if (variable("HOME").empty()) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("data folder: HOME and XDG_DATA_HOME are not set; {}", kRemedy));
  }
  TONUS_TRY_ASSIGN(const fs::path home, private_folder("HOME"));
  return home / ".local" / "share" / "tonus";
}

/// Where earlier versions kept the data; empty: no home.
fs::path earlier_folder() {
  if (const auto state = variable("XDG_STATE_HOME"); !state.empty()) return fs::path(state) / "tonus";
  const auto home = variable("HOME");
  return home.empty() ? fs::path() : fs::path(home) / ".local" / "state" / "tonus";
}

}  // namespace

Result<fs::path> default_data_folder() {
  if (const auto state = variable("STATE_DIRECTORY"); !state.empty())
    return fs::path(state.substr(0, state.find(':')));
  TONUS_TRY_ASSIGN(const fs::path folder, folder_of_user());
  TONUS_TRY_ASSIGN(const bool is_there, is_present(folder));
  const fs::path earlier = earlier_folder();
  if (is_there || earlier.empty()) return folder;
  TONUS_TRY_ASSIGN(const bool has_earlier, is_present(earlier));
  if (has_earlier) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("data folder: an earlier version kept its data in '{}'; move it to '{}', or say "
                            "--data FOLDER",
                            earlier.string(), folder.string()));
  }
  return folder;
}

Result<fs::path> default_rig_folder(const std::string& rig) {
  TONUS_TRY_ASSIGN(const bool has_system, is_present(kSystem));
  if (has_system) return fs::path(kSystem) / "rigs" / rig;
  TONUS_TRY_ASSIGN(const fs::path folder, default_data_folder());
  return folder / "rigs" / rig;
}

bool is_url(const std::string& name) { return name.find("://") != std::string::npos; }

}  // namespace tonus
