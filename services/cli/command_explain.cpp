#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "services/cli/answer.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/formats_page.hpp"
#include "services/cli/key_documents.hpp"
#include "services/core/json_text.hpp"
#include "services/explain/explanation.hpp"
#include "services/runtime/options.hpp"

namespace tonus::cli {
namespace {

struct ExplainOptions {
  std::vector<std::string> words;
  std::string page;
  bool is_json = false;
};

std::string first_sentence(std::string_view text) {
  const auto end = text.find(". ");
  return std::string(text.substr(0, end == std::string_view::npos ? end : end + 1));
}

nlohmann::json json_of(const explain::Found& found) {
  return {{"name", found.text->name},
          {"kind", explain::kind_name(found.kind)},
          {"meaning", found.text->meaning},
          {"causes", found.text->causes},
          {"remedy", found.text->remedy}};
}

/// All of them, a line each.
std::string list() {
  std::string text;
  for (const explain::Kind kind : explain::kKinds) {
    text += fmt::format("{}{}\n", text.empty() ? "" : "\n", explain::kind_name(kind));
    for (const auto& one : explain::explanations(kind))
      text += fmt::format("  {:<22} {}\n", one.name, first_sentence(one.meaning));
  }
  return text;
}

std::vector<explain::Found> everything() {
  std::vector<explain::Found> all;
  for (const explain::Kind kind : explain::kKinds) {
    for (const auto& one : explain::explanations(kind)) all.push_back({kind, &one});
  }
  return all;
}

Result<std::string> page_of(const std::string& name) {
  if (name == "formats") return formats_page();
  return name == "keys" ? keys_page() : explain::reasons_page();
}

Result<void> explain_reason(const ExplainOptions& options) {
  if (!options.page.empty()) {
    TONUS_TRY_ASSIGN(const auto text, page_of(options.page));
    std::fputs(text.c_str(), stdout);
    return {};
  }
  std::string words;
  for (const auto& word : options.words) words += (words.empty() ? "" : " ") + word;
  if (words.empty() && !options.is_json) {
    std::fputs(list().c_str(), stdout);
    return {};
  }
  if (const std::string keys = explained_keys(words); !keys.empty() && !options.is_json) {
    std::fputs(keys.c_str(), stdout);
    return {};
  }
  auto found = words.empty() ? Result<std::vector<explain::Found>>(everything()) : explain::find(words);
  if (!found) return found.error();
  if (options.is_json) {
    nlohmann::json all = nlohmann::json::array();
    for (const auto& one : *found) all.push_back(json_of(one));
    std::printf("%s\n", json_text(all).c_str());
    return {};
  }
  for (std::size_t i = 0; i < found->size(); ++i)
    std::printf("%s%s", i == 0 ? "" : "\n", explain::as_text((*found)[i]).c_str());
  return {};
}

}  // namespace

void add_explain_command(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand("explain",
                                     "Says what a reason means, where it comes from and what to do, or what "
                                     "a key of a file is; alone, it lists all reasons.");
  auto options = std::make_shared<ExplainOptions>();
  command->add_option(
      "reason", options->words,
      "of a verdict, an estimate, a fault or a hold, the rig's line for its hold, or a key of a file");
  add_json_flag(*command, options->is_json);
  command->add_option("--page", options->page, "print a page of the manual, in Markdown")
      ->check(CLI::IsMember({"reasons", "keys", "formats"}))
      ->group("");
  command->callback([options, &chosen] {
    chosen = [options] {
      const auto outcome = explain_reason(*options);
      return outcome ? 0 : runtime::report("tonus explain", outcome.error());
    };
  });
}

}  // namespace tonus::cli
