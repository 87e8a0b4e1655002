#include "services/runtime/settings_files.hpp"

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>
#include <sstream>

#include "services/config/toml_text.hpp"
#include "services/core/text_file.hpp"
#include "services/runtime/settings.hpp"

namespace tonus::runtime {
namespace {

constexpr std::size_t kLargestFile = std::size_t{1} << 20U;

/// As the command line would have it; nothing for what no option can be.
std::optional<std::string> text_of(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  if (const auto* whole = node.as_integer()) return std::to_string(whole->get());
  if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
  return std::nullopt;
}

std::optional<std::vector<std::string>> texts_of(const toml::node& node) {
  std::vector<std::string> texts;
  if (const auto* array = node.as_array()) {
    for (const auto& element : *array) {
      const auto text = text_of(element);
      if (!text) return std::nullopt;
      texts.push_back(*text);
    }
    return texts;
  }
  const auto text = text_of(node);
  if (!text) return std::nullopt;
  texts.push_back(*text);
  return texts;
}

std::string dotted(const std::string& name, std::string_view key) {
  return name.empty() ? std::string(key) : name + "." + std::string(key);
}

Words with_subcommands(Words words, const CLI::App& app) {
  for (const auto* sub : app.get_subcommands({})) words.insert(sub->get_name());
  return words;
}

}  // namespace

Words keys_of(const CLI::App& app, bool only_common) {
  Words keys;
  for (const auto* option : app.get_options()) {
    if (!option->get_configurable() || option->get_lnames().empty()) continue;
    if (!only_common || option->get_group() == kCommonGroup) keys.insert(option->get_lnames().front());
  }
  for (const auto* sub : app.get_subcommands({})) keys.merge(keys_of(*sub, only_common));
  return keys;
}

Result<std::optional<SettingsFile>> SettingsFile::open(const std::string& path) {
  const auto text = read_text_file(path, kLargestFile);
  if (!text) {
    if (text.error().code == ErrorCode::kNotFound) return std::optional<SettingsFile>();
    return fail(text.error().code, "configuration " + text.error().message);
  }
  TONUS_TRY_ASSIGN(auto table, config::parse_toml(*text, path));
  return std::optional<SettingsFile>(SettingsFile(path, std::move(table)));
}

const toml::table* SettingsFile::table_at(const std::vector<std::string>& path) const {
  const toml::table* table = &table_;
  for (const auto& name : path) {
    const auto* node = table->get(name);
    table = node == nullptr ? nullptr : node->as_table();
    if (table == nullptr) return nullptr;
  }
  return table;
}

Error SettingsFile::refuse(const toml::key& key, const std::string& name, const std::string& why) const {
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("{}:{}: {}: {}", path_, key.source().begin.line, dotted(name, key.str()), why));
}

Result<void> SettingsFile::check(const toml::table& table, const std::string& name,
                                 const CLI::App& app) const {
  const Words keys = keys_of(app);
  for (const auto& [key, node] : table) {
    if (const auto* inner = node.as_table()) {
      const std::string_view word = key.str();
      const auto found = app.get_subcommands([word](const CLI::App* sub) { return sub->get_name() == word; });
      if (found.empty())
        return refuse(key, name, "unknown table; " + instead_of(key.str(), with_subcommands({}, app)));
      TONUS_TRY(check(*inner, dotted(name, key.str()), *found.front()));
    } else if (!keys.contains(key.str())) {
      return refuse(key, name, "unknown key; " + instead_of(key.str(), with_subcommands(keys, app)));
    } else if (!texts_of(node)) {
      return refuse(key, name,
                    "this kind of value is not allowed; expected text, a number, true, false or a list");
    }
  }
  return {};
}

Result<void> SettingsFile::check_section(const std::vector<std::string>& path, const CLI::App& app) const {
  const toml::table* table = table_at(path);
  if (table == nullptr) return {};
  std::string name;
  for (const auto& part : path) name = dotted(name, part);
  return check(*table, name, app);
}

Result<void> SettingsFile::check_top(const CLI::App& program, const Words& sections) const {
  Words known = keys_of(program, true);
  const bool has_common_options = !known.empty();  // tonus-driver-contract has none
  for (const auto& [key, node] : table_) {
    if (!node.is_table() && !has_common_options && !sections.contains(key.str())) continue;
    if (node.is_table() ? sections.contains(key.str()) : known.contains(key.str()) && texts_of(node))
      continue;
    if (!node.is_table() && known.contains(key.str()))
      return refuse(key, "",
                    "this kind of value is not allowed; expected text, a number, true, false or a list");
    if (!node.is_table() && sections.contains(key.str()))
      return refuse(key, "", fmt::format("is a section; expected [{}]", key.str()));
    known.insert(sections.begin(), sections.end());
    return refuse(key, "", "unknown key; " + instead_of(key.str(), known));
  }
  return {};
}

std::optional<FileValue> SettingsFile::find(const std::vector<std::string>& path,
                                            const std::string& key) const {
  const toml::table* table = table_at(path);
  const toml::node* node = table == nullptr ? nullptr : table->get(key);
  if (node == nullptr || node->is_table()) return std::nullopt;
  auto texts = texts_of(*node);
  if (!texts) return std::nullopt;
  return FileValue{std::move(*texts), fmt::format("{}:{}", path_, node->source().begin.line)};
}

}  // namespace tonus::runtime
