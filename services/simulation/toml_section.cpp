#include "services/simulation/toml_section.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <sstream>

namespace tonus::simulation {
namespace {

// A value as it stands in the file, on one line.
std::string text_of(const toml::node& node) {
  if (node.is_table()) return "a table";
  if (const auto number = node.as_floating_point()) return fmt::format("{}", number->get());
  if (const auto* array = node.as_array()) {
    std::string list;
    for (const auto& element : *array) list += (list.empty() ? "" : ", ") + text_of(element);
    return "[" + list + "]";
  }
  std::ostringstream text;
  text << toml::default_formatter(node);
  std::string line = text.str();
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line;
}

}  // namespace

void FirstProblem::report(const std::string& what) {
  if (result_) result_ = fail(ErrorCode::kInvalidArgument, source_ + ": " + what);
}

void TomlSection::number(std::string_view key, double& target, double low, double high) {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  double value = 0.0;
  if (!in_limits(*node, low, high, value))
    return refuse(key, *node, fmt::format("a number from {} to {}", low, high));
  target = value;
}

void TomlSection::pair(std::string_view key, Eigen::Vector2d& target, double low, double high) {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const toml::array* array = node->as_array();
  Eigen::Vector2d value;
  if (array == nullptr || array->size() != 2 || !in_limits(*array->get(0), low, high, value[0]) ||
      !in_limits(*array->get(1), low, high, value[1])) {
    return refuse(key, *node, fmt::format("two numbers from {} to {}", low, high));
  }
  target = value;
}

void TomlSection::count(std::string_view key, std::uint64_t& target, std::uint64_t low, std::uint64_t high) {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  if (!is_count(*node, low, high))
    return refuse(key, *node, fmt::format("a whole number from {} to {}", low, high));
  target = static_cast<std::uint64_t>(node->value_exact<std::int64_t>().value_or(0));
}

void TomlSection::counts(std::string_view key, std::vector<std::uint64_t>& target, std::uint64_t low,
                         std::uint64_t high) {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const toml::array* array = node->as_array();
  const auto is_good = [&](const toml::node& element) { return is_count(element, low, high); };
  if (array == nullptr || !std::all_of(array->begin(), array->end(), is_good)) {
    return refuse(key, *node, fmt::format("a list of whole numbers from {} to {}", low, high));
  }
  target.clear();
  for (const toml::node& element : *array)
    target.push_back(static_cast<std::uint64_t>(element.value_exact<std::int64_t>().value_or(0)));
}

void TomlSection::count(std::string_view key, unsigned& target, unsigned low, unsigned high) {
  std::uint64_t value = target;
  count(key, value, std::uint64_t{low}, std::uint64_t{high});
  target = static_cast<unsigned>(value);
}

void TomlSection::flag(std::string_view key, bool& target) {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const auto value = node->value_exact<bool>();
  if (!value) return refuse(key, *node, "true or false");
  target = *value;
}

TomlSection TomlSection::section(std::string_view key) {
  const toml::node* node = find(key);
  if (node != nullptr && !node->is_table()) refuse(key, *node, "a table");
  return {node == nullptr ? nullptr : node->as_table(), name_of(key), problem_};
}

void TomlSection::finish() {
  if (table_ == nullptr) return;
  for (const auto& [key, node] : *table_) {
    if (std::find(known_.begin(), known_.end(), key.str()) != known_.end()) continue;
    problem_.report(
        fmt::format("{} is an unknown key, allowed are {}", name_of(key.str()), fmt::join(known_, ", ")));
    return;
  }
}

const toml::node* TomlSection::find(std::string_view key) {
  known_.emplace_back(key);
  return table_ == nullptr ? nullptr : table_->get(key);
}

std::string TomlSection::name_of(std::string_view key) const {
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

void TomlSection::refuse(std::string_view key, const toml::node& node, const std::string& allowed) {
  problem_.report(fmt::format("{} is {}, allowed is {}", name_of(key), text_of(node), allowed));
}

bool TomlSection::is_count(const toml::node& node, std::uint64_t low, std::uint64_t high) {
  const auto value = node.value_exact<std::int64_t>();
  return value && *value >= 0 && static_cast<std::uint64_t>(*value) >= low &&
         static_cast<std::uint64_t>(*value) <= high;
}

// Whole numbers are numbers too; a value that is not finite is outside every limit.
bool TomlSection::in_limits(const toml::node& node, double low, double high, double& value) const {
  if (!node.is_number()) return false;
  value = node.value<double>().value_or(low - 1.0);
  return value >= low && value <= high;
}

}  // namespace tonus::simulation
