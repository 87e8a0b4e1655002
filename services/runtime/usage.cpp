#include "services/runtime/usage.hpp"

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstring>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "services/core/nearest_word.hpp"
#include "services/core/text.hpp"

namespace tonus::runtime {
namespace {

const CLI::App* command_of(const CLI::App& app, const std::string& word) {
  for (const auto* sub : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (sub->get_name() == word) return sub;
  }
  return nullptr;
}

bool has_commands(const CLI::App& app) {
  return !app.get_subcommands([](const CLI::App*) { return true; }).empty();
}

bool takes_words(const CLI::App& app) {
  for (const auto* option : app.get_options()) {
    if (option->get_positional()) return true;
  }
  return false;
}

/// "--domain" of "--domain=3"; empty for a value, a negative number among them.
std::string option_in(const std::string& word) {
  if (word.size() < 2 || word[0] != '-' || std::isdigit(static_cast<unsigned char>(word[1])) != 0 ||
      word[1] == '.')
    return "";
  return word.starts_with("--") ? word.substr(0, word.find('=')) : word.substr(0, 2);
}

std::string meant(const std::string& word, const Words& known) {
  const std::string text = instead_of(word, known);
  return text.starts_with("did you mean") ? text : "";
}

std::string unknown_option(const CLI::App& app, const std::string& name, const std::string& option) {
  Words known;
  for (const auto* one : app.get_options()) {
    if (one->get_group().empty()) continue;
    for (const auto& long_name : one->get_lnames()) known.insert("--" + long_name);
  }
  const std::string hint = meant(option, known);
  return fmt::format("{}: {}: unknown option; {}", name, shown(option),
                     hint.empty() ? name + " --help lists the options" : hint);
}

std::string unknown_command(const CLI::App& app, const std::string& name, const std::string& word) {
  Words known;
  for (const auto* sub : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (!sub->get_group().empty()) known.insert(sub->get_name());
  }
  const std::string hint = meant(word, known);
  return fmt::format("{}: '{}' is not a command; {}", name, shown(word),
                     hint.empty() ? name + " --help lists them" : hint);
}

/// What an interrupt prints; a handler may only use what is there.
char interrupted_line[128];

void end(int number) {
  const auto written = write(STDERR_FILENO, interrupted_line, strlen(interrupted_line));
  (void)written;
  _exit(128 + number);
}

}  // namespace

std::optional<std::string> unknown_word(const CLI::App& app, const std::vector<std::string>& words) {
  const CLI::App* at = &app;
  std::string name = app.get_name();
  for (std::size_t i = 0; i < words.size() && words[i] != "--"; ++i) {
    if (const std::string option = option_in(words[i]); !option.empty()) {
      const auto* known = at->get_option_no_throw(option);
      if (known == nullptr) return unknown_option(*at, name, option);
      const bool has_value = words[i].find('=') != std::string::npos || words[i].size() > option.size();
      if (!has_value && known->get_items_expected_max() > 0) ++i;  // its value
    } else if (const auto* command = command_of(*at, words[i])) {
      at = command;
      name += " " + words[i];
    } else if (has_commands(*at) && !takes_words(*at)) {
      return unknown_command(*at, name, words[i]);
    }
  }
  return std::nullopt;
}

void end_when_interrupted(const char* program) {
  fmt::format_to_n(interrupted_line, sizeof interrupted_line - 1, "{}: interrupted\n", program);
  struct sigaction action {};
  action.sa_handler = end;
  sigemptyset(&action.sa_mask);
  for (const int number : {SIGINT, SIGTERM}) sigaction(number, &action, nullptr);
}

}  // namespace tonus::runtime
