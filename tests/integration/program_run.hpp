#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tonus::testing {

/// What a program of the system that has ended gave.
struct ProgramRun {
  int code = 0;  ///< Exit code, or -signal.
  std::string output;
  std::string errors;
};

/// Runs a program to its end; `shell` is what the shell puts before or after it, with "$@" for program and
/// arguments: `env -u HOME "$@"`, `"$@" > /dev/full`. `folder` is for what it prints.
[[nodiscard]] ProgramRun run_program(const std::string& name, const std::vector<std::string>& arguments,
                                     const std::filesystem::path& folder,
                                     const std::string& shell = "\"$@\"");

/// Whether a run was refused as it should be: not 0, no signal, one line on standard error.
[[nodiscard]] bool is_refused_in_one_line(const ProgramRun& run);

}  // namespace tonus::testing
