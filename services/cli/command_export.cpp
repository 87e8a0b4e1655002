#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "services/cli/answer.hpp"
#include "services/cli/archive_option.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/progress_bar.hpp"
#include "services/cli/session_text.hpp"
#include "services/core/json_text.hpp"
#include "services/core/text.hpp"
#include "services/formats/csv_export.hpp"
#include "services/formats/hdf5_export.hpp"
#include "services/formats/session_recordings.hpp"
#include "services/formats/xdf_export.hpp"
#include "services/recording/dataset.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/version.hpp"
#include "services/store/session_list.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::cli {
namespace {

namespace fs = std::filesystem;

struct ExportOptions {
  ArchiveOption archive;
  std::string session;
  std::string format;
  std::string out;
  bool is_all = false;  ///< Every session that has samples, as one BIDS dataset.
  bool is_json = false;
};

Result<void> export_bids(store::Store& store, const store::Session& session, const fs::path& out,
                         const Progress& progress) {
  const auto recordings = formats::recordings_of(store, session, progress);
  if (!recordings) return recordings.error();
  recording::WriteOptions options;
  options.software_version = runtime::kVersion;
  // What BIDS has no place for: kept beside, where its tools do not look.
  options.further_files = {{"sourcedata/tonus/session.json", json_text(session_json(session)) + "\n"},
                           {"code/protocol.toml", session.plan.protocol_toml()}};
  return recording::write_dataset(out, *recordings, options);
}

Result<void> export_session(const ExportOptions& options) {
  auto store = open_to_read(options.archive);
  if (!store) return store.error();
  const auto session = store::read_found_session(**store, options.session);
  if (!session) return session.error();
  ProgressBar bar("trials");
  const auto progress = [&bar](std::uint64_t done, std::uint64_t total) { bar.show(done, total, ""); };
  Result<void> done;
  if (options.format == "bids") {
    done = export_bids(**store, *session, options.out, progress);
  } else if (options.format == "csv") {
    done = formats::export_csv(**store, *session, options.out,
                               {{"session.json", json_text(session_json(*session)) + "\n"}}, progress);
  } else if (options.format == "xdf") {
    done = formats::export_xdf(**store, *session, options.out, progress);
  } else {
    done = formats::export_hdf5(**store, *session, options.out, progress);
  }
  bar.clear();
  if (!done) return done;
  const std::string id = to_hex(session->record.session);
  print_answer(options.is_json,
               {{"sessions", nlohmann::json::array({id})}, {"format", options.format}, {"to", options.out}},
               fmt::format("session {}: {}\n", id, shown(options.out)));
  return {};
}

/// What BIDS has no place for, of one session among several.
void keep_beside(const store::Session& session, recording::WriteOptions& options) {
  const std::string label = "ses-" + to_hex(session.record.session).substr(0, 8);
  options.further_files.emplace_back("sourcedata/tonus/" + label + "/session.json",
                                     json_text(session_json(session)) + "\n");
  options.further_files.emplace_back("code/" + label + "/protocol.toml", session.plan.protocol_toml());
}

/// One dataset of all sessions: a study, or all that an archive holds. Sessions without samples are named and
/// left out.
Result<void> export_all(const ExportOptions& options) {
  if (options.format != "bids" || !options.session.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                options.session.empty()
                    ? "--all: --format " + options.format + " is not allowed; expected bids"
                    : "--all: a session is not allowed beside it: " + options.session);
  }
  TONUS_TRY_ASSIGN(const auto store, open_to_read(options.archive));
  TONUS_TRY_ASSIGN(const auto records, store::list_sessions(*store));
  TONUS_TRY_ASSIGN(const auto subjects, store::list_subjects(*store));
  recording::WriteOptions writing;
  writing.software_version = runtime::kVersion;
  std::vector<recording::Recording> all;
  std::vector<std::string> sessions;
  ProgressBar bar("sessions");
  for (const auto& record : records) {
    bar.show(sessions.size(), records.size(), record.subject);
    TONUS_TRY_ASSIGN(const auto session, store::read_session(*store, record.session));
    auto recordings = formats::recordings_of(*store, session);
    if (!recordings && recordings.error().code != ErrorCode::kNotFound) return recordings.error();
    if (!recordings) {
      bar.say("left out: " + shown(recordings.error().message));
      continue;
    }
    sessions.push_back(to_hex(record.session));
    keep_beside(session, writing);
    const auto subject = std::ranges::find(subjects, record.subject, &store::KnownSubject::subject);
    for (auto& recording : *recordings) {
      if (subject != subjects.end())
        recording.participant = formats::participant_of(record.subject, subject->facts);
    }
    std::move(recordings->begin(), recordings->end(), std::back_inserter(all));
  }
  bar.clear();
  if (all.empty())
    return fail(ErrorCode::kNotFound, "store '" + store->name() + "' has no session with samples");
  TONUS_TRY(recording::write_dataset(options.out, all, writing));
  print_answer(
      options.is_json, {{"sessions", sessions}, {"format", options.format}, {"to", options.out}},
      fmt::format("{} sessions, {} recordings: {}\n", sessions.size(), all.size(), shown(options.out)));
  return {};
}

}  // namespace

void add_export_command(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand("export", "Writes an archived session for other programs.");
  auto options = std::make_shared<ExportOptions>();
  command->add_option("session", options->session, "its id or the beginning of it (default: the last one)");
  add_archive_option(*command, options->archive);
  command->add_flag("--all", options->is_all, "every session of the archive, as one BIDS dataset");
  command->add_option("--format", options->format, "bids or csv (a folder), hdf5 or xdf (a file)")
      ->required()
      ->check(CLI::IsMember({"bids", "csv", "hdf5", "xdf"}));
  command->add_option("--out", options->out, "path that does not exist yet")->required();
  add_json_flag(*command, options->is_json);
  command->callback([options, &chosen] {
    chosen = [options] {
      const auto outcome = options->is_all ? export_all(*options) : export_session(*options);
      return outcome ? 0 : runtime::report("tonus export", outcome.error());
    };
  });
}

}  // namespace tonus::cli
