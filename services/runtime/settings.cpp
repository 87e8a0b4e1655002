#include "services/runtime/settings.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <spdlog/fmt/fmt.h>
#include <sstream>

#include "services/core/installation.hpp"
#include "services/core/passwords.hpp"
#include "services/runtime/settings_files.hpp"

namespace tonus::runtime {
namespace {

using Path = std::vector<std::string>;

const Words kSections{"archive", "dashboard", "identification", "rig-agent", "scheduler", "tonus"};
constexpr char kRigAgent[] = "rig-agent";
constexpr char kCommandLineProgram[] = "tonus";
constexpr char kAgentTable[] = "agent";

std::string as_variable(const std::string& name) {
  std::string variable = name;
  std::transform(variable.begin(), variable.end(), variable.begin(), [](unsigned char c) {
    return c == '-' || c == '.' ? '_' : static_cast<char>(std::toupper(c));
  });
  return variable;
}

/// An empty variable counts as not set, as usual.
std::optional<std::string> environment(const std::string& name) {
  const char* value = std::getenv(name.c_str());
  return value == nullptr || *value == '\0' ? std::nullopt : std::optional<std::string>(value);
}

bool is_list(const CLI::Option& option) { return option.get_items_expected_max() > 1; }

std::string joined(const Path& path) {
  std::string text;
  for (const auto& part : path) text += (text.empty() ? "" : ".") + part;
  return text;
}

/// Whether it can stand in a file: no positional, not --help and its like.
bool has_key(const CLI::Option& option) { return option.get_configurable() && !option.get_lnames().empty(); }

}  // namespace

std::string section_of(const std::string& program) {
  constexpr std::string_view kPrefix = "tonus-";
  return program.starts_with(kPrefix) ? program.substr(kPrefix.size()) : program;
}

std::vector<std::string> variables_of(const Path& path, const std::string& key, bool is_common) {
  std::vector<std::string> names;
  Path left = path;
  const bool is_command_line = !left.empty() && left.front() == kCommandLineProgram;
  if (is_command_line) left.erase(left.begin());
  for (; !left.empty(); left.pop_back())
    names.push_back("TONUS_" + as_variable(joined(left)) + "_" + as_variable(key));
  if (is_common || is_command_line) names.push_back("TONUS_" + as_variable(key));
  return names;
}

std::optional<std::string> argument_of(std::string_view name, const std::vector<std::string>& words) {
  const std::string option = "--" + std::string(name);
  std::optional<std::string> value;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--") break;
    if (words[i] == option && i + 1 < words.size()) value = words[i + 1];
    if (words[i].starts_with(option + "=")) value = words[i].substr(option.size() + 1);
  }
  return value;
}

/// Looks every option up and applies what it finds.
class SettingsReader {
 public:
  SettingsReader(CLI::App& program, const std::vector<std::string>& words)
      : program_(program), words_(words), section_(section_of(program.get_name())) {}

  Result<Settings> read() {
    TONUS_TRY(open_host_file());
    TONUS_TRY(open_rig_file());
    TONUS_TRY(visit(program_, {section_}, true));
    return std::move(settings_);
  }

 private:
  Result<void> open_host_file() {
    auto named = argument_of("config", words_);
    if (!named) named = environment("TONUS_CONFIG");
    if (named == kNoFile) return {};
    is_named_ = named.has_value();
    const std::string path = named ? *named : (installation().configuration / "tonus.toml").string();
    folder_ = std::filesystem::path(path).parent_path();
    TONUS_TRY_ASSIGN(host_, SettingsFile::open(path));
    if (!host_) {
      if (!named) return {};
      return fail(ErrorCode::kNotFound,
                  fmt::format("--config: {}: no such file; expected a TOML file, or {}", path, kNoFile));
    }
    Words sections = kSections;
    sections.insert(section_);
    TONUS_TRY(host_->check_top(program_, sections));
    return host_->check_section({section_}, program_);
  }

  Result<void> open_rig_file() {
    if (section_ != kRigAgent || folder_.empty()) return {};
    auto rig = argument_of("rig", words_);
    if (!rig) {
      const auto said = find({section_}, "rig", true, true);
      rig = said && !said->values.empty() ? said->values.front() : "rig";
    }
    if (rig->empty() || rig->find('/') != std::string::npos) return {};
    TONUS_TRY_ASSIGN(rig_, SettingsFile::open((folder_ / "rigs" / (*rig + ".toml")).string()));
    return rig_ ? rig_->check_section({kAgentTable}, program_) : Result<void>();
  }

  std::optional<Settings::Said> find(const Path& path, const std::string& key, bool is_common,
                                     bool reads_files) const {
    for (const auto& variable : variables_of(path, key, is_common)) {
      if (const auto value = environment(variable))
        return Settings::Said{{*value}, variable + " in the environment"};
    }
    if (!reads_files) return std::nullopt;
    if (rig_) {
      Path in_rig = path;
      for (in_rig.front() = kAgentTable; !in_rig.empty(); in_rig.pop_back()) {
        if (auto found = rig_->find(in_rig, key)) return Settings::Said{found->values, found->source};
      }
      // All of the rig's file but [agent] is its profile.
      if (key == "profile" && !(host_ && host_->find({section_}, key)))
        return Settings::Said{{rig_->path()}, rig_->path()};
    }
    if (!host_) return std::nullopt;
    for (Path left = path; !left.empty(); left.pop_back()) {
      if (auto found = host_->find(left, key)) return Settings::Said{found->values, found->source};
    }
    if (!is_common) return std::nullopt;
    auto found = host_->find({}, key);
    return found ? std::optional(Settings::Said{found->values, found->source}) : std::nullopt;
  }

  Result<void> visit(CLI::App& app, const Path& path, bool reads_files) {
    // A command whose --config is none by default, as `tonus demo`, is private to this machine, whatever the
    // lab's file says.
    const auto* config = app.get_option_no_throw("--config");
    const bool is_private = config != nullptr && config->get_default_str() == kNoFile;
    reads_files = reads_files && (is_named_ || !is_private);
    for (CLI::Option* option : app.get_options({})) {
      if (!has_key(*option)) continue;
      const auto said =
          find(path, option->get_lnames().front(), option->get_group() == kCommonGroup, reads_files);
      if (said) TONUS_TRY(apply(*option, *said));
    }
    lift_needs(app);
    for (CLI::App* sub : app.get_subcommands({})) {
      Path inner = path;
      inner.push_back(sub->get_name());
      TONUS_TRY(visit(*sub, inner, reads_files));
    }
    return {};
  }

  /// Checks and takes the values as the command line's would be, and leaves the option as if not given.
  Result<void> apply(CLI::Option& option, Settings::Said said) {
    if (said.values.size() == 1 && is_list(option) && said.source.ends_with(" in the environment"))
      said.values = CLI::detail::split_up(said.values.front(), option.get_delimiter());
    std::string text;
    for (const auto& value : said.values) text += (text.empty() ? "" : ", ") + value;
    try {
      if (!text.empty()) {
        for (const auto& value : said.values) option.add_result(value);
        option.run_callback();
        option.clear();
        option.default_str(text);
        option.required(false);
      }
    } catch (const CLI::Error& error) {
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("{}: {}: {} is not allowed: {}", said.source, option.get_lnames().front(),
                              without_passwords(text), without_passwords(error.what())));
    }
    settings_.said_[&option] = std::move(said);
    return {};
  }

  /// What a file sets fulfils the needs of others.
  void lift_needs(CLI::App& app) {
    for (CLI::Option* option : app.get_options({})) {
      for (CLI::Option* needed : option->get_needs()) {
        if (settings_.said_.contains(needed)) option->remove_needs(needed);
      }
    }
  }

  CLI::App& program_;
  const std::vector<std::string>& words_;
  std::string section_;
  bool is_named_ = false;
  std::filesystem::path folder_;
  std::optional<SettingsFile> host_;
  std::optional<SettingsFile> rig_;
  Settings settings_;
};

Result<Settings> Settings::apply(CLI::App& program, const std::vector<std::string>& words) {
  return SettingsReader(program, words).read();
}

Result<void> Settings::check(const CLI::App& program) const {
  for (const auto* option : program.get_options()) {
    const auto said = said_.find(option);
    if (said == said_.end()) continue;
    for (const auto* needed : option->get_needs()) {
      if (needed->count() > 0 || said_.contains(needed)) continue;
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("{}: {} needs {}", said->second.source, option->get_lnames().front(),
                              needed->get_lnames().front()));
    }
  }
  for (const auto* sub : program.get_subcommands()) TONUS_TRY(check(*sub));
  return {};
}

namespace {

/// The first part of "INT:INT in [0 - 232]".
std::string kind_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return type.substr(0, type.find(':'));
}

void add_settings(std::vector<Setting>& all, const CLI::App& app, const Path& path, bool is_chosen,
                  const std::map<const CLI::Option*, Settings::Said>& said) {
  for (const auto* option : app.get_options()) {
    if (!has_key(*option)) continue;
    const auto found = said.find(option);
    const bool is_given = option->count() > 0;
    // Of a command that is not asked for: what was said of it alone.
    if (!is_chosen && (found == said.end() || option->get_group() == kCommonGroup)) continue;
    const bool is_flag = option->get_items_expected_max() == 0;
    Setting setting{
        .section = joined(path), .key = option->get_lnames().front(), .values = {}, .source = "default"};
    setting.is_list = is_list(*option);
    const std::string kind = kind_of(*option);
    setting.is_text = !is_flag && kind != "INT" && kind != "UINT" && kind != "FLOAT" && kind != "BOOLEAN";
    if (is_given) {
      setting.values = option->reduced_results();
      setting.source = "command line";
    } else if (found != said.end()) {
      setting.values = found->second.values;
      setting.source = found->second.source;
    } else if (is_flag) {
      setting.values = {"false"};
    } else if (!option->get_default_str().empty()) {
      setting.values = setting.is_list ? CLI::detail::split_up(option->get_default_str(), ',')
                                       : std::vector<std::string>{option->get_default_str()};
      for (auto& value : setting.values) std::erase_if(value, [](char c) { return c == '[' || c == ']'; });
    }
    for (auto& value : setting.values) value = without_passwords(value);
    all.push_back(std::move(setting));
  }
  for (const auto* sub : app.get_subcommands({})) {
    Path inner = path;
    inner.push_back(sub->get_name());
    add_settings(all, *sub, inner, is_chosen && sub->parsed(), said);
  }
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (static_cast<unsigned char>(c) >= ' ') result += c;
  }
  return result + "\"";
}

std::string value_text(const Setting& setting) {
  std::string text;
  for (const auto& value : setting.values)
    text += (text.empty() ? "" : ", ") + (setting.is_text ? quoted(value) : value);
  return setting.is_list ? "[" + text + "]" : text;
}

}  // namespace

std::vector<Setting> Settings::in_force(const CLI::App& program) const {
  std::vector<Setting> all;
  add_settings(all, program, {section_of(program.get_name())}, true, said_);
  return all;
}

std::string settings_text(const std::vector<Setting>& settings) {
  std::string text;
  std::string section;
  for (const auto& setting : settings) {
    if (setting.section != section)
      text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", setting.section);
    section = setting.section;
    if (setting.values.empty()) {
      text += fmt::format("# {} is not set\n", setting.key);
    } else {
      text += fmt::format("{:<50}  # {}\n", setting.key + " = " + value_text(setting), setting.source);
    }
  }
  return text;
}

}  // namespace tonus::runtime
