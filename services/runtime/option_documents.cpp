#include "services/runtime/option_documents.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <map>
#include <spdlog/fmt/fmt.h>
#include <vector>

#include "services/runtime/settings.hpp"
#include "services/runtime/version.hpp"

namespace tonus::runtime {
namespace {

using Path = std::vector<std::string>;

/// An option as a person sees it.
struct Shown {
  std::string names;   ///< "--window"; "protocol" for a positional
  std::string value;   ///< "TEXT", "INT in 0 to 232"; empty for a flag
  std::string what;    ///< its description
  std::string preset;  ///< default, if there is one
  bool is_positional = false;
  bool is_flag = false;
  bool is_required = false;
  std::string key;        ///< of the file; empty: it has none
  std::string variables;  ///< "TONUS_ARCHIVE_LIMIT_MB"
  std::string choices;    ///< "real max"; empty: not a choice
  bool is_file = false;
};

/// "--help" of "-h,--help".
std::string long_name(const Shown& o) { return o.names.substr(o.names.rfind(',') + 1); }

/// "{a,b}" of a choice's type as "a b".
std::string choices_of(const std::string& type) {
  const auto begin = type.find('{');
  const auto end = type.find('}', begin);
  if (begin == std::string::npos || end == std::string::npos) return "";
  std::string choices = type.substr(begin + 1, end - begin - 1);
  std::replace(choices.begin(), choices.end(), ',', ' ');
  return choices;
}

std::string without_repeat(const std::string& type) {
  const auto colon = type.find(':');
  return colon == std::string::npos ? type : type.substr(colon + 1);
}

Shown shown(const CLI::Option& option, const Path& path) {
  Shown s;
  s.is_positional = option.get_positional();
  s.is_flag = option.get_items_expected_max() == 0;
  s.names = s.is_positional ? option.get_name(true) : option.get_name(false, true);
  s.value = s.is_flag ? "" : without_repeat(option.get_type_name());
  s.choices = choices_of(s.value);
  s.is_file = s.value.find("FILE") != std::string::npos || s.value.find("DIR") != std::string::npos;
  s.what = option.get_description();
  s.preset = option.get_default_str();
  s.is_required = option.get_required();
  if (option.get_configurable() && !option.get_lnames().empty()) {
    s.key = option.get_lnames().front();
    for (const auto& name : variables_of(path, s.key, option.get_group() == kCommonGroup))
      s.variables += (s.variables.empty() ? "" : ", ") + name;
  }
  return s;
}

std::vector<Shown> options_of(const CLI::App& app, const Path& path, bool common) {
  std::vector<Shown> all;
  for (const auto* option : app.get_options()) {
    if (option->get_group().empty() || (option->get_group() == kCommonGroup) != common) continue;
    all.push_back(shown(*option, path));
  }
  return all;
}

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  const auto all = app.get_subcommands([](const CLI::App* sub) { return !sub->get_group().empty(); });
  return {all.begin(), all.end()};
}

Path inside(Path path, const CLI::App& sub) {
  path.push_back(sub.get_name());
  return path;
}

std::string dotted(const Path& path) {
  std::string text;
  for (const auto& part : path) text += (text.empty() ? "" : ".") + part;
  return text;
}

/// What follows a description in every document: range, default, needed.
std::string facts(const Shown& o) {
  std::string text;
  if (!o.value.empty() && o.choices.empty() && o.value.find(" in ") != std::string::npos)
    text += " Allowed: " + o.value.substr(o.value.find(" in ") + 4) + ".";
  if (!o.choices.empty()) text += " One of: " + o.choices + ".";
  if (!o.preset.empty() && !o.is_flag) text += " Default: " + o.preset + ".";
  if (o.is_required) text += " Must be given.";
  return text;
}

std::string value_word(const Shown& o) {
  if (o.is_flag || o.is_positional) return "";
  if (!o.choices.empty()) return "CHOICE";
  return o.value.substr(0, o.value.find(' ')).empty() ? "VALUE" : o.value.substr(0, o.value.find(' '));
}

// --- manual page

std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if (c == '\n')
      out += '\n';
    else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n'))
      out += std::string("\\&") + c;
    else
      out += c;
  }
  return out;
}

std::string man_option(const Shown& o) {
  std::string text = ".TP\n\\fB" + roff(o.names) + "\\fR";
  if (const auto word = value_word(o); !word.empty()) text += " \\fI" + roff(word) + "\\fR";
  text += "\n" + (o.what.empty() ? std::string("\\&") : roff(o.what) + ".") + roff(facts(o)) + "\n";
  return text;
}

/// The footer of --help: "Example:" and indented lines.
std::string man_example(const CLI::App& app) {
  const std::string footer = app.get_footer();
  if (footer.empty()) return "";
  return ".PP\nExample:\n.PP\n.EX\n" + roff(footer.substr(footer.find('\n') + 1)) + "\n.EE\n";
}

void add_man_command(std::string& text, const CLI::App& app, const Path& path, const std::string& name) {
  text += ".SS " + roff(name) + "\n" + roff(app.get_description()) + "\n";
  for (const auto& option : options_of(app, path, false)) text += man_option(option);
  text += man_example(app);
  for (const auto* sub : commands_of(app))
    add_man_command(text, *sub, inside(path, *sub), name + " " + sub->get_name());
}

std::string man_page(const CLI::App& app) {
  const std::string program = app.get_name();
  const Path path{section_of(program)};
  const auto commands = commands_of(app);
  std::string text =
      fmt::format(".\\\" Made from the program's own options.\n.TH {} 1 \"\" \"tonus {}\" \"tonus\"\n",
                  roff(program), roff(kVersion));
  std::string what = app.get_description();
  if (what.ends_with('.')) what.pop_back();
  text += fmt::format(".SH NAME\n{} \\- {}\n.SH SYNOPSIS\n.B {}\n{}[\\fIoptions\\fR]\n.SH DESCRIPTION\n{}\n",
                      roff(program), roff(what), roff(program), commands.empty() ? "" : "\\fIcommand\\fR\n",
                      roff(app.get_description()));
  text += ".SH OPTIONS\n";
  for (const auto& option : options_of(app, path, false)) text += man_option(option);
  if (commands.empty()) text += man_example(app);
  const auto& with_common =
      commands.empty() || !options_of(app, path, true).empty() ? app : *commands.front();
  std::string common;
  for (const auto& option : options_of(with_common, path, true)) common += man_option(option);
  if (!commands.empty()) text += ".SH COMMANDS\n";
  for (const auto* sub : commands)
    add_man_command(text, *sub, inside(path, *sub), program + " " + sub->get_name());
  if (!common.empty()) text += ".SH COMMON OPTIONS\nWhat every program has.\n" + common;
  const std::string& section = path.front();
  text += fmt::format(
      ".SH CONFIGURATION\nAn option that is not given comes from the environment, else from\n"
      ".IR /etc/tonus/tonus.toml :\na key with the option's name in the section\n.BR [{0}]{1}.\n"
      "The keys of the common options also stand at the top of the file.\n"
      "Variables are named after section and option, e.g.\n.BR {2} .\n"
      ".B tonus config\nprints what is in force, and where each value comes from.\n"
      ".SH FILES\n.TP\n.I /etc/tonus/tonus.toml\nThe options of all programs on this host.\n"
      ".TP\n.I /etc/tonus/rigs/NAME.toml\nOptions of the rig agent for the rig NAME ([agent]), and the rig's "
      "profile.\n"
      ".TP\n.I /var/lib/tonus\nThe data of an installed system.\n"
      ".SH EXIT STATUS\n0: done. 1: failed, with one line on standard error. 2: the command line, the "
      "environment or a file\n"
      "was refused, with one line on standard error. 130: ended by Ctrl\\-C before it was done.\n.SH SEE "
      "ALSO\n.I /usr/share/doc/tonus\\-cli/lab.md\n",
      roff(section), commands.empty() ? "" : " or, of one command, [" + roff(section) + ".COMMAND]",
      roff(variables_of(path, "dds", true).back()));
  return text;
}

// --- completion

std::string words_of(const CLI::App& app) {
  std::string words;
  for (const bool common : {false, true}) {
    for (const auto& o : options_of(app, {}, common)) {
      if (!o.is_positional) words += (words.empty() ? "" : " ") + long_name(o);
    }
  }
  words += words.empty() ? "--help" : "";
  for (const auto* sub : commands_of(app)) words += " " + sub->get_name();
  std::replace(words.begin(), words.end(), ',', ' ');
  return words;
}

void add_bash_cases(std::string& cases, const CLI::App& app, const std::string& name) {
  cases += fmt::format("    '{}') words='{}' ;;\n", name, words_of(app));
  for (const auto* sub : commands_of(app)) add_bash_cases(cases, *sub, name + " " + sub->get_name());
}

void add_choices(std::map<std::string, std::string>& choices, const CLI::App& app) {
  for (const bool common : {false, true}) {
    for (const auto& o : options_of(app, {}, common)) {
      if (!o.choices.empty()) choices[long_name(o)] = o.choices;
    }
  }
  for (const auto* sub : commands_of(app)) add_choices(choices, *sub);
}

std::string function_name(std::string program) {
  std::replace(program.begin(), program.end(), '-', '_');
  return "_" + program + "_options";
}

std::string bash_completion(const CLI::App& app) {
  const std::string function = function_name(app.get_name());
  std::map<std::string, std::string> choices;
  add_choices(choices, app);
  std::string values;
  for (const auto& [name, words] : choices)
    values += fmt::format("    {}) mapfile -t COMPREPLY < <(compgen -W '{}' -- \"$current\"); return ;;\n",
                          name, words);
  std::string cases;
  add_bash_cases(cases, app, "");
  return fmt::format(
      "# bash completion for {0}; made from the program's own options\n"
      "{1}() {{\n"
      "  local current=${{COMP_WORDS[COMP_CWORD]}} command='' words='' i\n"
      "  COMPREPLY=()\n"
      "  case ${{COMP_WORDS[COMP_CWORD-1]}} in\n{2}    *) ;;\n  esac\n"
      "  for ((i = 1; i < COMP_CWORD; i++)); do\n"
      "    case \"$command ${{COMP_WORDS[i]}}\" in\n{3}    esac\n"
      "  done\n"
      "  case $command in\n{4}  esac\n"
      "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
      "}}\n"
      "complete -o default -F {1} {0}\n",
      app.get_name(), function, values,
      [&] {
        std::string known;
        const std::function<void(const CLI::App&, const std::string&)> add = [&](const CLI::App& at,
                                                                                 const std::string& name) {
          for (const auto* sub : commands_of(at)) {
            const std::string inner = name + " " + sub->get_name();
            known += fmt::format("      '{0}') command='{0}' ;;\n", inner);
            add(*sub, inner);
          }
        };
        add(app, "");
        return known + "      *) ;;\n";
      }(),
      cases);
}

std::string zsh_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\'')
      out += "'\\''";
    else if (c == '[' || c == ']' || c == ':' || c == '\\')
      out += std::string("\\") + c;
    else
      out += c;
  }
  return out;
}

std::string zsh_option(const Shown& o) {
  const std::string name = long_name(o);
  std::string text = fmt::format("'*{}[{}]", name, zsh_text(o.what));
  if (!o.is_flag) {
    text += ":" + zsh_text(value_word(o)) + ":";
    text += o.choices.empty() ? (o.is_file ? "_files" : " ") : "(" + zsh_text(o.choices) + ")";
  }
  return text + "'";
}

void add_zsh_function(std::string& text, const CLI::App& app, const std::string& function) {
  std::string inner;
  std::string lines;
  for (const bool common : {false, true}) {
    for (const auto& o : options_of(app, {}, common)) {
      if (!o.is_positional) lines += " \\\n    " + zsh_option(o);
    }
  }
  const auto commands = commands_of(app);
  if (commands.empty()) {
    text += function + "() {\n  _arguments" + lines + " \\\n    '*:file:_files'\n}\n";
    return;
  }
  std::string list;
  std::string cases;
  for (const auto* sub : commands) {
    list += fmt::format("    '{}:{}'\n", sub->get_name(), zsh_text(sub->get_description()));
    std::string name = function + "_" + sub->get_name();
    std::replace(name.begin(), name.end(), '-', '_');
    cases += fmt::format("    {}) {} ;;\n", sub->get_name(), name);
    add_zsh_function(inner, *sub, name);
  }
  text += inner + function + "() {\n  local state line\n  local -a commands=(\n" + list +
          "  )\n  _arguments -C" + lines + " \\\n    '1:command:->command' '*::argument:->argument'\n" +
          "  case $state in\n    command) _describe command commands ;;\n    argument) case $line[1] in\n" +
          cases + "    esac ;;\n  esac\n}\n";
}

std::string zsh_completion(const CLI::App& app) {
  std::string text = fmt::format("#compdef {}\n# Made from the program's own options.\n", app.get_name());
  const std::string function = function_name(app.get_name());
  add_zsh_function(text, app, function);
  return text + function + " \"$@\"\n";
}

// --- reference and the keys of the file

std::string cell(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

void add_reference(std::string& text, const CLI::App& app, const Path& path, const std::string& name,
                   int depth) {
  text += fmt::format("{} {}\n\n{}\n\n", std::string(static_cast<std::size_t>(depth), '#'), name,
                      app.get_description());
  std::string rows;
  for (const bool common : {false, true}) {
    for (const auto& o : options_of(app, path, common)) {
      if (common && path.size() > 1) continue;
      const std::string left = o.names + (value_word(o).empty() ? "" : " " + value_word(o));
      rows += fmt::format("| `{}` | {} | {} |\n", cell(left), cell(o.what + facts(o)),
                          o.variables.empty() ? "" : "`" + o.variables + "`");
    }
  }
  if (!rows.empty())
    text += fmt::format("Section `[{}]`.\n\n| option | what | variable |\n|---|---|---|\n{}\n", dotted(path),
                        rows);
  for (const auto* sub : commands_of(app))
    add_reference(text, *sub, inside(path, *sub), name + " " + sub->get_name(), depth + 1);
}

void add_keys(std::string& text, const CLI::App& app, const Path& path, bool common) {
  std::string keys;
  for (const auto& o : options_of(app, path, common)) {
    if (o.key.empty()) continue;
    const bool is_bare =
        o.is_flag || o.value.starts_with("INT") || o.value.starts_with("UINT") ||
        o.value.starts_with("FLOAT") ||
        (!o.preset.empty() && o.preset.find_first_not_of("0123456789.-+e") == std::string::npos);
    const std::string value = o.is_flag                      ? "false"
                              : is_bare && !o.preset.empty() ? o.preset
                                                             : "\"" + o.preset + "\"";
    keys += fmt::format("# {}{}\n#{} = {}\n", o.what, facts(o), o.key, value);
  }
  if (!keys.empty()) text += (common ? "" : fmt::format("\n[{}]\n", dotted(path))) + keys;
}

}  // namespace

Result<std::string> option_document(const CLI::App& app, const std::string& kind) {
  const Path path{section_of(app.get_name())};
  std::string text;
  if (kind == "man") return man_page(app);
  if (kind == "bash") return bash_completion(app);
  if (kind == "zsh") return zsh_completion(app);
  if (kind == "reference") {
    add_reference(text, app, path, app.get_name(), 2);
    return text;
  }
  if (kind == "toml") {
    add_keys(text, app, path, false);
    return text;
  }
  if (kind == "toml-common") {
    add_keys(text, app, path, true);
    return text;
  }
  return fail(
      ErrorCode::kInvalidArgument,
      fmt::format(
          "--print-document: {} is not allowed; expected man, bash, zsh, reference, toml or toml-common",
          kind));
}

}  // namespace tonus::runtime
