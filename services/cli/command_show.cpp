#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "services/cli/answer.hpp"
#include "services/cli/archive_option.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/session_text.hpp"
#include "services/core/json_text.hpp"
#include "services/runtime/options.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::cli {
namespace {

struct ShowOptions {
  ArchiveOption archive;
  std::string session;
  bool is_json = false;
};

Result<void> show(const ShowOptions& options) {
  auto store = open_to_read(options.archive);
  if (!store) return store.error();
  const auto session = store::read_found_session(**store, options.session);
  if (!session) return session.error();
  const std::string text =
      options.is_json ? json_text(session_json(*session)) + "\n" : session_text(*session);
  std::fputs(text.c_str(), stdout);
  return {};
}

}  // namespace

void add_show_command(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand("show", "Shows an archived session: plan, trials, estimates, settings.");
  auto options = std::make_shared<ShowOptions>();
  command->add_option("session", options->session, "its id or the beginning of it (default: the last one)");
  add_archive_option(*command, options->archive);
  add_json_flag(*command, options->is_json);
  command->callback([options, &chosen] {
    chosen = [options] {
      const auto outcome = show(*options);
      return outcome ? 0 : runtime::report("tonus show", outcome.error());
    };
  });
}

}  // namespace tonus::cli
