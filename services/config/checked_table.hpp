#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <toml++/toml.h>
#include <vector>

#include "services/protocol/protocol.hpp"

namespace tonus::config {

/// Inclusive limits of a number, with the unit for messages.
struct Limits {
  double low;
  double high;
  const char* unit = "";
};

/// What reading a file has found: where each key stands, and the first problem.
struct Findings {
  std::string source;
  std::map<std::string, int> lines;
  std::optional<std::string> problem;

  void report(int line, const std::string& text);
};

/// One table of a TOML file, read key by key with limits. A getter that meets a problem reports it and
/// returns something harmless, so that a reader goes straight on; who has read all calls finish(), which
/// refuses the keys that nobody asked for, and looks at the findings once.
class CheckedTable {
 public:
  CheckedTable(const toml::table& table, std::string path, int line, Findings& findings)
      : table_(table), path_(std::move(path)), line_(line), findings_(findings) {}

  [[nodiscard]] bool has(std::string_view key);
  [[nodiscard]] double number(std::string_view key, Limits limits, std::optional<double> fallback = {});
  [[nodiscard]] int whole(std::string_view key, int low, int high, std::optional<int> fallback = {});
  [[nodiscard]] std::uint64_t seed(std::string_view key, std::uint64_t fallback);
  [[nodiscard]] bool flag(std::string_view key, bool fallback);
  /// Text of `least` to `most` characters, no control characters.
  [[nodiscard]] std::string text(std::string_view key, std::size_t least, std::size_t most,
                                 std::optional<std::string> fallback = {});
  [[nodiscard]] std::string one_of(std::string_view key, const std::vector<std::string>& allowed,
                                   std::optional<std::string> fallback = {});
  /// [low, high] with low <= high, or one number for both.
  [[nodiscard]] protocol::Span span(std::string_view key, Limits limits);
  [[nodiscard]] Eigen::Vector2d vector(std::string_view key, Limits limits,
                                       std::optional<Eigen::Vector2d> fallback = {});
  [[nodiscard]] std::vector<std::string> texts(std::string_view key, const std::vector<std::string>& allowed);
  /// The table `key`; reports it as missing and gives an empty one if it is not there.
  [[nodiscard]] CheckedTable table(std::string_view key);
  /// The tables [[key]], `least` to `most` of them.
  [[nodiscard]] std::vector<CheckedTable> tables(std::string_view key, std::size_t least, std::size_t most);

  /// "source:line: key = value is not allowed: allowed", with the value as the file has it.
  void refuse(std::string_view key, const std::string& allowed);
  /// Reports every key that was not asked for as unknown.
  void finish();

  [[nodiscard]] std::string name_of(std::string_view key) const;

 private:
  /// The node, noted as asked for; nullptr and, unless it may be, reported as missing.
  const toml::node* find(std::string_view key, bool may_be_missing, const std::string& allowed);
  [[nodiscard]] int line_of(const toml::node& node) const;
  [[nodiscard]] std::optional<double> number_in(const toml::node& node, Limits limits) const;

  const toml::table& table_;
  std::string path_;
  int line_;
  Findings& findings_;
  std::set<std::string, std::less<>> asked_;
};

}  // namespace tonus::config
