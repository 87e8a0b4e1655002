#pragma once

#include <optional>
#include <string>
#include <toml++/toml.h>
#include <vector>

#include "services/core/nearest_word.hpp"
#include "services/core/result.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace tonus::runtime {

/// A value as a file has it, as texts that the command line would have.
struct FileValue {
  std::vector<std::string> values;
  std::string source;  ///< "FILE:LINE"
};

/// A TOML file of options, checked against the program that reads it.
class SettingsFile {
 public:
  /// Nothing where there is no such file; another error where it cannot be read or is not TOML.
  [[nodiscard]] static Result<std::optional<SettingsFile>> open(const std::string& path);

  /// Whether all keys of the table at `path` are options of `app`, and its tables are subcommands of it. A
  /// missing table is right.
  [[nodiscard]] Result<void> check_section(const std::vector<std::string>& path, const CLI::App& app) const;

  /// Whether the keys at the top are common options of `program` and the tables are sections.
  [[nodiscard]] Result<void> check_top(const CLI::App& program, const Words& sections) const;

  /// The value of `key` in the table at `path`.
  [[nodiscard]] std::optional<FileValue> find(const std::vector<std::string>& path,
                                              const std::string& key) const;

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  SettingsFile(std::string path, toml::table table) : path_(std::move(path)), table_(std::move(table)) {}
  [[nodiscard]] const toml::table* table_at(const std::vector<std::string>& path) const;
  [[nodiscard]] Result<void> check(const toml::table& table, const std::string& name,
                                   const CLI::App& app) const;
  [[nodiscard]] Error refuse(const toml::key& key, const std::string& name, const std::string& why) const;

  std::string path_;
  toml::table table_;
};

/// Names of the options of `app`, of its subcommands too, that can stand in a file. With `only_common` those
/// of kCommonGroup.
[[nodiscard]] Words keys_of(const CLI::App& app, bool only_common = false);

}  // namespace tonus::runtime
