#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <toml++/toml.h>
#include <vector>

#include "services/config/span.hpp"

namespace tonus::config {

/// Inclusive limits of a number, with the unit for messages.
struct Limits {
  double low;
  double high;
  const char* unit = "";
};

/// A key that a reader asks for, as the reader checks it.
struct Key {
  std::string name;      ///< From the root: "bias.force_N", "posture[].name".
  std::string expected;  ///< Type and range as a refusal states them: "0.05 to 20 N".
  std::string preset;    ///< Default; "none" where it may be absent and has none.
  bool is_needed = false;
};

/// What reading a file has found: where each key stands, and the first problem; later ones are not kept.
struct Findings {
  std::string source;
  std::map<std::string, int> lines;
  std::optional<std::string> problem;
  /// Where it is not null, nothing is read and no problem counts: every key that the reader asks for is noted
  /// here, each table as if it existed once (keys_of()).
  std::vector<Key>* keys = nullptr;

  /// "source:line: text"; without the line where it is 0.
  void report(int line, const std::string& text);
  /// "source:line: name: value is not allowed; expected limits", at the line of the key where it has one.
  void refuse(const std::string& name, const std::string& value, const std::string& expected);
};

/// One table of a TOML file, read key by key: each call states a key with its type, limits and default. A
/// getter that meets a problem reports it and returns something harmless, so that a reader goes straight on;
/// after all calls, finish() refuses the keys that nobody asked for, and the findings are looked at once.
/// The getters with a target keep its value as the default where the key is absent or refused.
class CheckedTable {
 public:
  /// `path` is the table's name from the root, "" for the root; `line` 0: unknown.
  CheckedTable(const toml::table& table, std::string path, int line, Findings& findings)
      : table_(table), path_(std::move(path)), line_(line), findings_(findings) {}

  [[nodiscard]] bool has(std::string_view key);
  [[nodiscard]] double number(std::string_view key, Limits limits, std::optional<double> fallback = {});
  [[nodiscard]] int whole(std::string_view key, int low, int high, std::optional<int> fallback = {});
  [[nodiscard]] std::uint64_t seed(std::string_view key, std::uint64_t fallback);
  /// Text of `least` to `most` characters, no control characters.
  [[nodiscard]] std::string text(std::string_view key, std::size_t least, std::size_t most,
                                 const std::optional<std::string>& fallback = {});
  [[nodiscard]] std::string one_of(std::string_view key, const std::vector<std::string>& allowed,
                                   const std::optional<std::string>& fallback = {});
  /// [low, high] with low <= high, or one number for both.
  [[nodiscard]] Span span(std::string_view key, Limits limits);
  [[nodiscard]] Eigen::Vector2d vector(std::string_view key, Limits limits,
                                       std::optional<Eigen::Vector2d> fallback = {});
  [[nodiscard]] std::vector<std::string> texts(std::string_view key, const std::vector<std::string>& allowed);

  void number(std::string_view key, double& target, double low, double high);
  void pair(std::string_view key, Eigen::Vector2d& target, double low, double high);
  void count(std::string_view key, std::uint64_t& target, std::uint64_t low, std::uint64_t high);
  void count(std::string_view key, unsigned& target, unsigned low, unsigned high);
  void counts(std::string_view key, std::vector<std::uint64_t>& target, std::uint64_t low,
              std::uint64_t high);
  /// One number stands for both.
  void one_or_two(std::string_view key, std::array<unsigned, 2>& target, unsigned low, unsigned high,
                  bool is_needed);
  void flag(std::string_view key, bool& target);

  /// The table `key`; reports it as missing and gives an empty one where it is absent.
  [[nodiscard]] CheckedTable table(std::string_view key);
  /// The table `key`, or an empty one where it is absent.
  [[nodiscard]] CheckedTable optional_table(std::string_view key);
  /// The tables [[key]], `least` to `most` of them.
  [[nodiscard]] std::vector<CheckedTable> tables(std::string_view key, std::size_t least, std::size_t most);

  /// "source:line: key: value is not allowed; expected limits", with the value as the file has it.
  void refuse(std::string_view key, const std::string& expected);
  /// Refuses the keys that were not asked for, and names the key that was probably meant.
  void finish();

  [[nodiscard]] std::string name_of(std::string_view key) const;

 private:
  /// The node, noted as asked for; nullptr and, unless there is a default, reported as missing.
  const toml::node* find(std::string_view key, const std::optional<std::string>& preset,
                         const std::string& expected);
  void note(Key key);
  [[nodiscard]] int line_of(const toml::node& node) const;
  [[nodiscard]] std::optional<double> number_in(const toml::node& node, Limits limits) const;

  const toml::table& table_;
  std::string path_;
  int line_;
  Findings& findings_;
  std::set<std::string, std::less<>> asked_;
  std::set<std::string, std::less<>> looked_for_;  // by has(): may be absent
};

/// All keys of a reader, in the order in which it asks for them, each once. `read` gets the findings to read
/// with.
template <typename Read>
[[nodiscard]] std::vector<Key> keys_of(const Read& read) {
  static const toml::table kNothing;
  std::vector<Key> keys;
  Findings findings;
  findings.keys = &keys;
  read(CheckedTable(kNothing, "", 0, findings), findings);
  return keys;
}

/// The unit that a key's name bears, of its last part that bears one: "N/m" of "grip.stiffness_N_per_m", else
/// "".
[[nodiscard]] std::string unit_of(std::string_view key);

}  // namespace tonus::config
