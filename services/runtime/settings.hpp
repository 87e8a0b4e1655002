#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/result.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

/// Options that a program is not told on its command line: they come from the environment, else from the
/// rig's file, else from the host's file, else they keep the default. The registered options are the one
/// table of names, types, ranges and defaults; an option needs nothing else to be a key and a variable.
///
///     option                       key in tonus.toml                  variable
///     --domain (every program)     domain, or domain in [archive]     TONUS_DOMAIN, TONUS_ARCHIVE_DOMAIN
///     tonus-archive --limit-MB     limit-MB in [archive]              TONUS_ARCHIVE_LIMIT_MB
///     tonus run --seed             seed in [tonus.run] or [tonus]     TONUS_RUN_SEED, TONUS_SEED
///
/// In this order, the special before the general. rigs/NAME.toml holds the rig agent's options for that rig
/// in [agent]; all else in it is the rig's profile.
namespace tonus::runtime {

/// The group of the options that every program has: their keys also stand at the top of the file.
inline constexpr char kCommonGroup[] = "Common options";

/// `--config none`: no file. A command with this as its --config's default reads a file only if it is named.
inline constexpr char kNoFile[] = "none";

/// One option as it is in force.
struct Setting {
  std::string section;              ///< "archive", "tonus.run"
  std::string key;                  ///< "limit-MB"
  std::vector<std::string> values;  ///< Without passwords; empty: not set.
  bool is_text = false;
  bool is_list = false;
  std::string source;  ///< "command line", "TONUS_DOMAIN in the environment", "FILE:LINE" or "default"
};

/// Section of a program's options: its name without "tonus-".
[[nodiscard]] std::string section_of(const std::string& program);

/// Variables that set an option, the special one first; `path` is the section and its subcommands.
[[nodiscard]] std::vector<std::string> variables_of(const std::vector<std::string>& path,
                                                    const std::string& key, bool is_common);

/// The value of `--name VALUE` or `--name=VALUE` among the words, the last one.
[[nodiscard]] std::optional<std::string> argument_of(std::string_view name,
                                                     const std::vector<std::string>& words);

/// What environment and files say of a program's options.
class Settings {
 public:
  /// Finds and checks the files, and gives each option of `program` and its subcommands what is said of it as
  /// its new default. Call before the command line is parsed. The error names file, line, key and what is
  /// allowed; an unknown key gets the one that was probably meant.
  [[nodiscard]] static Result<Settings> apply(CLI::App& program, const std::vector<std::string>& words);

  /// After parsing: an option that needs another one which is set nowhere.
  [[nodiscard]] Result<void> check(const CLI::App& program) const;

  /// Of the program and of the subcommand that was chosen; of the others, what was said of them.
  [[nodiscard]] std::vector<Setting> in_force(const CLI::App& program) const;

  struct Said {
    std::vector<std::string> values;
    std::string source;
  };

 private:
  friend class SettingsReader;
  std::map<const CLI::Option*, Said> said_;
};

/// The settings as TOML that could be a tonus.toml, each with its source as a comment.
[[nodiscard]] std::string settings_text(const std::vector<Setting>& settings);

}  // namespace tonus::runtime
