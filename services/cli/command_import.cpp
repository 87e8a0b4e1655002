#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <spdlog/fmt/fmt.h>
#include <sstream>

#include "analysis_service/service/command_line.hpp"
#include "services/cli/answer.hpp"
#include "services/cli/archive_option.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/progress_bar.hpp"
#include "services/core/clock.hpp"
#include "services/core/folder.hpp"
#include "services/core/lifetime.hpp"
#include "services/core/text.hpp"
#include "services/import/session_import.hpp"
#include "services/recording/dataset.hpp"
#include "services/runtime/configuration.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/version.hpp"
#include "services/store/open_store.hpp"

namespace tonus::cli {
namespace {

struct ImportOptions {
  std::string dataset;
  ArchiveOption archive;
  identification::CommandLine analysis;
  std::string configuration;  ///< The options as TOML.
  bool is_json = false;
};

/// The settings of identification as its service would archive them; the force's sign, which is stated in the
/// sessions' rig descriptions, excepted.
std::string archived_configuration(const CLI::App& command) {
  std::istringstream all(runtime::configuration_text(command));
  std::string kept;
  for (std::string line; std::getline(all, line);) {
    if (!line.starts_with("force-sign") && !line.starts_with("json")) kept += line + "\n";
  }
  return kept;
}

/// What stands in the way of writing to an archive that is there, before the long work; none is made.
Result<void> check_archive(const std::string& name) {
  TONUS_TRY_ASSIGN(const bool is_there, is_present(name));
  if (!is_there) return {};
  const auto store = store::open_store_for_writing(name);
  if (!store) return store.error();
  return {};
}

Result<void> import(const ImportOptions& options) {
  TONUS_TRY_ASSIGN(auto usable, recording::read_usable(options.dataset));
  const auto analysis = options.analysis.settings("");
  if (!analysis) return analysis.error();
  if (analysis->force_sign < 0.0) {
    TONUS_TRY(recording::state_force_sign(usable, -1));
  }
  for (const auto& item : usable.left_out)
    std::fprintf(stderr, "tonus import: left out: %s\n", shown(item).c_str());
  TONUS_TRY_ASSIGN(const std::string archive, options.archive.name());
  TONUS_TRY(check_archive(archive));
  const SystemClock clock;
  const session_import::ImportSettings settings{
      (std::filesystem::path(options.dataset) / "").parent_path().filename().string(), runtime::kVersion,
      clock.utc_ns(), analysis->core, options.configuration};
  ProgressBar bar("trials");
  const auto sessions = session_import::sessions_of(
      usable.recordings, settings,
      [&bar](std::uint64_t done, std::uint64_t total) { bar.show(done, total, ""); });
  bar.clear();
  if (!sessions) return sessions.error();
  // Nothing is on the disk until here. From here on an interrupt waits until a session is stored whole.
  const StopSignal stop;
  const auto store = store::open_store_for_writing(archive);
  if (!store) return store.error();
  const auto imported =
      session_import::store_sessions(**store, *sessions, [&stop] { return stop.is_requested(); });
  if (!imported) return imported.error();
  nlohmann::json json{{"sessions", nlohmann::json::array()}, {"left_out", usable.left_out}};
  std::string text;
  for (const auto& session : *imported) {
    json["sessions"].push_back({{"session", to_hex(session.session)},
                                {"subject", session.subject},
                                {"protocol", session.protocol_name},
                                {"trials", session.planned_trials}});
    text += fmt::format("session {}: {}, {}, {} trials\n", to_hex(session.session), session.subject,
                        session.protocol_name, session.planned_trials);
  }
  print_answer(options.is_json, std::move(json), text);
  return {};
}

}  // namespace

void add_import_command(CLI::App& app, Command& chosen) {
  auto* command =
      app.add_subcommand("import", "Puts a BIDS Motion dataset into an archive, and identifies it.");
  auto options = std::make_shared<ImportOptions>();
  command->add_option("dataset", options->dataset, "folder of the dataset")
      ->required()
      ->check(CLI::ExistingDirectory);
  add_archive_option(*command, options->archive);
  options->analysis.add_to(*command);
  add_json_flag(*command, options->is_json);
  command->callback([options, command, &chosen] {
    options->configuration = archived_configuration(*command);
    chosen = [options] {
      const auto outcome = import(*options);
      return outcome ? 0 : runtime::report("tonus import", outcome.error());
    };
  });
}

}  // namespace tonus::cli
