#include "services/config/checked_table.hpp"

#include <algorithm>
#include <cmath>
#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>
#include <sstream>
#include <utility>

#include "services/core/nearest_word.hpp"
#include "services/core/text.hpp"

namespace tonus::config {
namespace {

const toml::table kEmptyTable;

/// The value as a person would write it: the shortest form of a number, no line breaks, not too long.
std::string printed(const toml::node& node) {
  std::string text;
  if (const auto* number = node.as_floating_point()) {
    text = fmt::format("{}", number->get());
  } else if (const auto* words = node.as_string()) {
    text = fmt::format("\"{}\"", words->get());
  } else if (const auto* array = node.as_array()) {
    for (const auto& element : *array) text += (text.empty() ? "" : ", ") + printed(element);
    text = "[" + text + "]";
  } else {
    std::ostringstream out;
    node.visit([&out](const auto& value) { out << value; });
    text = out.str();
  }
  text = masked(std::move(text), TextKind::kLine);
  return text.size() > 60 ? text.substr(0, 57) + "..." : text;
}

std::string range_text(Limits limits) {
  return fmt::format("{} to {}{}{}", limits.low, limits.high, *limits.unit != '\0' ? " " : "", limits.unit);
}

bool is_count(const toml::node& node, std::uint64_t low, std::uint64_t high) {
  const auto* integer = node.as_integer();
  return integer != nullptr && integer->get() >= 0 && static_cast<std::uint64_t>(integer->get()) >= low &&
         static_cast<std::uint64_t>(integer->get()) <= high;
}

std::optional<std::string> preset_of(const auto& fallback) {
  return fallback ? std::optional(fmt::format("{}", *fallback)) : std::nullopt;
}

std::optional<std::string> quoted(const std::optional<std::string>& fallback) {
  return fallback ? std::optional(fmt::format("\"{}\"", *fallback)) : std::nullopt;
}

std::string choice_text(const std::vector<std::string>& allowed) {
  return fmt::format("one of {}", fmt::join(allowed, ", "));
}

}  // namespace

void Findings::report(int line, const std::string& text) {
  if (problem) return;
  problem = line > 0 ? fmt::format("{}:{}: {}", source, line, text) : fmt::format("{}: {}", source, text);
}

void Findings::refuse(const std::string& name, const std::string& value, const std::string& expected) {
  const auto line = lines.find(name);
  report(line == lines.end() ? 0 : line->second,
         fmt::format("{}: {} is not allowed; expected {}", name, value, expected));
}

bool CheckedTable::has(std::string_view key) {
  asked_.emplace(key);
  if (findings_.keys != nullptr) return looked_for_.emplace(key), true;
  return table_.contains(key);
}

std::string CheckedTable::name_of(std::string_view key) const {
  return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
}

int CheckedTable::line_of(const toml::node& node) const {
  const auto line = node.source().begin.line;
  return line > 0 ? static_cast<int>(line) : line_;
}

const toml::node* CheckedTable::find(std::string_view key, const std::optional<std::string>& preset,
                                     const std::string& expected) {
  asked_.emplace(key);
  if (findings_.keys != nullptr) {
    const bool may_be_absent = preset || looked_for_.contains(key);
    note({name_of(key), expected, looked_for_.contains(key) ? "none" : preset.value_or(""), !may_be_absent});
    return nullptr;
  }
  const toml::node* node = table_.get(key);
  if (node != nullptr) {
    if (const int line = line_of(*node); line > 0) findings_.lines[name_of(key)] = line;
  } else if (!preset) {
    findings_.report(line_, fmt::format("{} is missing; expected {}", name_of(key), expected));
  }
  return node;
}

void CheckedTable::note(Key key) {
  const auto is_same = [&](const Key& known) { return known.name == key.name; };
  if (std::none_of(findings_.keys->begin(), findings_.keys->end(), is_same))
    findings_.keys->push_back(std::move(key));
}

void CheckedTable::refuse(std::string_view key, const std::string& expected) {
  if (findings_.keys != nullptr) return;
  if (const toml::node* node = find(key, {}, expected))
    findings_.refuse(name_of(key), printed(*node), expected);
}

std::optional<double> CheckedTable::number_in(const toml::node& node, Limits limits) const {
  if (!node.is_number()) return std::nullopt;
  const auto value = node.value<double>();
  if (!value || !std::isfinite(*value) || *value < limits.low || *value > limits.high) return std::nullopt;
  return value;
}

double CheckedTable::number(std::string_view key, Limits limits, std::optional<double> fallback) {
  const toml::node* node = find(key, preset_of(fallback), range_text(limits));
  if (node == nullptr) return fallback.value_or(limits.low);
  const auto value = number_in(*node, limits);
  if (!value) refuse(key, range_text(limits));
  return value.value_or(fallback.value_or(limits.low));
}

int CheckedTable::whole(std::string_view key, int low, int high, std::optional<int> fallback) {
  const std::string allowed = fmt::format("a whole number, {} to {}", low, high);
  const toml::node* node = find(key, preset_of(fallback), allowed);
  if (node == nullptr) return fallback.value_or(low);
  const auto* integer = node->as_integer();
  if (integer != nullptr && integer->get() >= low && integer->get() <= high)
    return static_cast<int>(integer->get());
  refuse(key, allowed);
  return low;
}

std::uint64_t CheckedTable::seed(std::string_view key, std::uint64_t fallback) {
  const std::string allowed = "a whole number, 0 or more";
  const toml::node* node = find(key, fmt::format("{}", fallback), allowed);
  if (node == nullptr) return fallback;
  const auto* integer = node->as_integer();
  if (integer != nullptr && integer->get() >= 0) return static_cast<std::uint64_t>(integer->get());
  refuse(key, allowed);
  return fallback;
}

void CheckedTable::flag(std::string_view key, bool& target) {
  const toml::node* node = find(key, target ? "true" : "false", "true or false");
  if (node == nullptr) return;
  const auto* boolean = node->as_boolean();
  if (boolean == nullptr) return refuse(key, "true or false");
  target = boolean->get();
}

std::string CheckedTable::text(std::string_view key, std::size_t least, std::size_t most,
                               const std::optional<std::string>& fallback) {
  const std::string allowed = fmt::format("text of {} to {} characters", least, most);
  const toml::node* node = find(key, quoted(fallback), allowed);
  if (node == nullptr) return fallback.value_or("");
  const auto* text = node->as_string();
  if (text != nullptr && text->get().size() >= least && text->get().size() <= most &&
      shown(text->get()) == text->get()) {
    return text->get();
  }
  refuse(key, allowed);
  return "";
}

std::string CheckedTable::one_of(std::string_view key, const std::vector<std::string>& allowed,
                                 const std::optional<std::string>& fallback) {
  const toml::node* node = find(key, quoted(fallback), choice_text(allowed));
  if (node == nullptr) return fallback.value_or("");
  const auto* text = node->as_string();
  if (text != nullptr && std::find(allowed.begin(), allowed.end(), text->get()) != allowed.end())
    return text->get();
  refuse(key, choice_text(allowed));
  return "";
}

Span CheckedTable::span(std::string_view key, Limits limits) {
  const std::string allowed =
      fmt::format("[low, high] with low <= high, or one number, {}", range_text(limits));
  const toml::node* node = find(key, {}, allowed);
  if (node == nullptr) return {limits.low, limits.low};
  if (const auto single = number_in(*node, limits)) return {*single, *single};
  if (const auto* pair = node->as_array(); pair != nullptr && pair->size() == 2) {
    const auto low = number_in(*pair->get(0), limits);
    const auto high = number_in(*pair->get(1), limits);
    if (low && high && *low <= *high) return {*low, *high};
  }
  refuse(key, allowed);
  return {limits.low, limits.low};
}

Eigen::Vector2d CheckedTable::vector(std::string_view key, Limits limits,
                                     std::optional<Eigen::Vector2d> fallback) {
  const std::string allowed = fmt::format("[x, y], each {}", range_text(limits));
  const auto preset =
      fallback ? std::optional(fmt::format("[{}, {}]", fallback->x(), fallback->y())) : std::nullopt;
  const toml::node* node = find(key, preset, allowed);
  const Eigen::Vector2d zero = Eigen::Vector2d::Zero();
  if (node == nullptr) return fallback.value_or(zero);
  if (const auto* pair = node->as_array(); pair != nullptr && pair->size() == 2) {
    const auto x = number_in(*pair->get(0), limits);
    const auto y = number_in(*pair->get(1), limits);
    if (x && y) return {*x, *y};
  }
  refuse(key, allowed);
  return fallback.value_or(zero);
}

std::vector<std::string> CheckedTable::texts(std::string_view key, const std::vector<std::string>& allowed) {
  const std::string allowed_text = fmt::format("a list, each {}", choice_text(allowed));
  const toml::node* node = find(key, {}, allowed_text);
  std::vector<std::string> items;
  if (node == nullptr) return items;
  const auto* array = node->as_array();
  if (array == nullptr) return refuse(key, allowed_text), items;
  for (const auto& element : *array) {
    const auto* text = element.as_string();
    if (text == nullptr || std::find(allowed.begin(), allowed.end(), text->get()) == allowed.end()) {
      return refuse(key, allowed_text), std::vector<std::string>{};
    }
    items.push_back(text->get());
  }
  return items;
}

void CheckedTable::number(std::string_view key, double& target, double low, double high) {
  target = number(key, {low, high}, target);
}

void CheckedTable::pair(std::string_view key, Eigen::Vector2d& target, double low, double high) {
  target = vector(key, {low, high}, target);
}

void CheckedTable::count(std::string_view key, std::uint64_t& target, std::uint64_t low, std::uint64_t high) {
  const std::string expected = fmt::format("a whole number, {} to {}", low, high);
  const toml::node* node = find(key, fmt::format("{}", target), expected);
  if (node == nullptr) return;
  if (!is_count(*node, low, high)) return refuse(key, expected);
  target = static_cast<std::uint64_t>(node->as_integer()->get());
}

void CheckedTable::one_or_two(std::string_view key, std::array<unsigned, 2>& target, unsigned low,
                              unsigned high, bool is_needed) {
  const std::string expected = fmt::format("one or two whole numbers, each {} to {}", low, high);
  std::optional<std::string> preset;
  if (!is_needed) preset = fmt::format("[{}, {}]", target[0], target[1]);
  const toml::node* node = find(key, preset, expected);
  if (node == nullptr) return;
  const toml::array* array = node->as_array();
  if (array != nullptr && array->size() != 2) return refuse(key, expected);
  std::array<unsigned, 2> values{};
  for (std::size_t i = 0; i < 2; ++i) {
    const toml::node& element = array == nullptr ? *node : *array->get(i);
    if (!is_count(element, low, high)) return refuse(key, expected);
    values[i] = static_cast<unsigned>(element.as_integer()->get());
  }
  target = values;
}

void CheckedTable::count(std::string_view key, unsigned& target, unsigned low, unsigned high) {
  std::uint64_t value = target;
  count(key, value, std::uint64_t{low}, std::uint64_t{high});
  target = static_cast<unsigned>(value);
}

void CheckedTable::counts(std::string_view key, std::vector<std::uint64_t>& target, std::uint64_t low,
                          std::uint64_t high) {
  const std::string expected = fmt::format("a list of whole numbers, each {} to {}", low, high);
  const toml::node* node = find(key, fmt::format("[{}]", fmt::join(target, ", ")), expected);
  if (node == nullptr) return;
  const toml::array* array = node->as_array();
  const auto is_good = [&](const toml::node& element) { return is_count(element, low, high); };
  if (array == nullptr || !std::all_of(array->begin(), array->end(), is_good)) return refuse(key, expected);
  target.clear();
  for (const toml::node& element : *array)
    target.push_back(static_cast<std::uint64_t>(element.as_integer()->get()));
}

CheckedTable CheckedTable::optional_table(std::string_view key) {
  if (has(key)) return table(key);
  return {kEmptyTable, name_of(key), line_, findings_};
}

CheckedTable CheckedTable::table(std::string_view key) {
  if (findings_.keys != nullptr) return {kEmptyTable, name_of(key), line_, findings_};
  const std::string allowed = fmt::format("a table [{}]", name_of(key));
  const toml::node* node = find(key, {}, allowed);
  if (node == nullptr) return {kEmptyTable, name_of(key), line_, findings_};
  if (const auto* table = node->as_table()) return {*table, name_of(key), line_of(*node), findings_};
  refuse(key, allowed);
  return {kEmptyTable, name_of(key), line_of(*node), findings_};
}

std::vector<CheckedTable> CheckedTable::tables(std::string_view key, std::size_t least, std::size_t most) {
  const std::string allowed = fmt::format("{} to {} tables [[{}]]", least, most, name_of(key));
  std::vector<CheckedTable> all;
  if (findings_.keys != nullptr) {
    all.emplace_back(kEmptyTable, name_of(key) + "[]", line_, findings_);
    return all;
  }
  const toml::node* node = find(key, least == 0 ? std::optional<std::string>("none") : std::nullopt, allowed);
  if (node == nullptr) return all;
  const auto* array = node->as_array();
  const bool are_tables =
      array != nullptr &&
      std::all_of(array->begin(), array->end(), [](const toml::node& element) { return element.is_table(); });
  if (!are_tables) return refuse(key, allowed), all;
  if (array->size() < least || array->size() > most) {
    findings_.refuse(name_of(key), fmt::format("a list of {} tables", array->size()), allowed);
    return all;
  }
  for (std::size_t i = 0; i < array->size(); ++i) {
    const toml::node& element = *array->get(i);
    all.emplace_back(*element.as_table(), fmt::format("{}[{}]", name_of(key), i + 1), line_of(element),
                     findings_);
  }
  return all;
}

void CheckedTable::finish() {
  for (const auto& [key, node] : table_) {
    if (asked_.contains(key.str())) continue;
    const auto line = key.source().begin.line;
    findings_.report(line > 0 ? static_cast<int>(line) : line_,
                     fmt::format("{}: unknown key; {}", name_of(key.str()), instead_of(key.str(), asked_)));
  }
}

std::string unit_of(std::string_view key) {
  static const std::vector<std::pair<std::string_view, const char*>> kUnits{{"_Nms_per_rad", "N m s/rad"},
                                                                            {"_Nm_per_rad", "N m/rad"},
                                                                            {"_Nm_per_V", "N m/V"},
                                                                            {"_N_per_m", "N/m"},
                                                                            {"_N_per_V", "N/V"},
                                                                            {"_Ns_per_m", "N s/m"},
                                                                            {"_rad_per_s", "rad/s"},
                                                                            {"_m_per_s", "m/s"},
                                                                            {"_kg_m2", "kg m2"},
                                                                            {"_per_rev", "1/turn"},
                                                                            {"_per_s", "1/s"},
                                                                            {"_per_N", "1/N"},
                                                                            {"_count", "counts"},
                                                                            {"_deg", "deg"},
                                                                            {"_rad", "rad"},
                                                                            {"_Nm", "N m"},
                                                                            {"_Hz", "Hz"},
                                                                            {"_kg", "kg"},
                                                                            {"_N", "N"},
                                                                            {"_m", "m"},
                                                                            {"_s", "s"},
                                                                            {"_V", "V"},
                                                                            {"_J", "J"}};
  while (!key.empty()) {
    for (const auto& [suffix, unit] : kUnits) {
      if (key.ends_with(suffix)) return unit;
    }
    const auto dot = key.rfind('.');
    key = dot == std::string_view::npos ? std::string_view() : key.substr(0, dot);
  }
  return "";
}

}  // namespace tonus::config
