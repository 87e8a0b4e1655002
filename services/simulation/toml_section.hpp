#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <toml++/toml.h>
#include <vector>

#include "services/core/result.hpp"

namespace tonus::simulation {

/// The first thing that was wrong in a file; later ones are not looked at. Each message is one line that
/// begins with the source's name.
class FirstProblem {
 public:
  explicit FirstProblem(std::string_view source) : source_(source) {}

  void report(const std::string& what);
  [[nodiscard]] const Result<void>& result() const { return result_; }

 private:
  const std::string source_;
  Result<void> result_;
};

/// One table of a TOML file while it is read: each call looks for a key, checks type and limits, and writes
/// the target only when all is well; a key that is absent leaves it alone. finish() refuses the keys that
/// nobody asked for.
class TomlSection {
 public:
  /// `path` is the table's name from the root, "" for the root; the table may be null (absent).
  TomlSection(const toml::table* table, std::string path, FirstProblem& problem)
      : table_(table), path_(std::move(path)), problem_(problem) {}

  void number(std::string_view key, double& target, double low, double high);
  void pair(std::string_view key, Eigen::Vector2d& target, double low, double high);
  void count(std::string_view key, std::uint64_t& target, std::uint64_t low, std::uint64_t high);
  void count(std::string_view key, unsigned& target, unsigned low, unsigned high);
  void flag(std::string_view key, bool& target);
  void counts(std::string_view key, std::vector<std::uint64_t>& target, std::uint64_t low,
              std::uint64_t high);
  [[nodiscard]] TomlSection section(std::string_view key);
  void finish();

 private:
  [[nodiscard]] const toml::node* find(std::string_view key);
  [[nodiscard]] std::string name_of(std::string_view key) const;
  void refuse(std::string_view key, const toml::node& node, const std::string& allowed);
  [[nodiscard]] static bool is_count(const toml::node& node, std::uint64_t low, std::uint64_t high);
  [[nodiscard]] bool in_limits(const toml::node& node, double low, double high, double& value) const;

  const toml::table* table_;
  const std::string path_;
  FirstProblem& problem_;
  std::vector<std::string> known_;
};

}  // namespace tonus::simulation
