#include "services/core/installation.hpp"

#include <system_error>

namespace tonus {

Installation installation_of(const std::filesystem::path& program) {
  const auto programs = program.parent_path();
  const auto prefix = programs.parent_path();
  // In a build folder all programs lie together.
  std::error_code error;
  const auto helpers = prefix / "libexec" / "tonus";
  const bool has_helpers = std::filesystem::is_directory(helpers, error);
  return {.programs = programs,
          .helpers = has_helpers ? helpers : programs,
          .share = prefix / "share" / "tonus",
          .configuration = (prefix.filename() == "usr" ? prefix.parent_path() : prefix) / "etc" / "tonus"};
}

Installation installation() {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  return installation_of(error ? std::filesystem::current_path() / "program" : self);
}

}  // namespace tonus
