#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <set>
#include <spdlog/fmt/fmt.h>

#include "services/cli/answer.hpp"
#include "services/cli/archive_option.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/progress_bar.hpp"
#include "services/core/clock.hpp"
#include "services/core/places.hpp"
#include "services/core/text.hpp"
#include "services/runtime/options.hpp"
#include "services/store/copy.hpp"
#include "services/store/open_store.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::cli {
namespace {

Result<std::vector<Id>> ids_of(store::Store& store, const std::vector<std::string>& wanted) {
  std::vector<Id> ids;
  for (const std::string& name : wanted) {
    TONUS_TRY_ASSIGN(const auto record, store::find_session(store, name));
    ids.push_back(record.session);
  }
  return ids;
}

Progress progress_of(ProgressBar& bar) {
  return [&bar](std::uint64_t done, std::uint64_t total) { bar.show(done, total, ""); };
}

struct CopyOptions {
  ArchiveOption archive;
  std::string to;
  std::vector<std::string> sessions;
  bool is_json = false;
};

Result<store::CopyCount> copy_to(store::Store& from, const std::string& to,
                                 const store::CopySelection& selection, const Progress& progress) {
  if (!is_url(to)) return store::copy_to_sqlite(from, to, selection, progress);
  TONUS_TRY_ASSIGN(const auto target, store::open_store_for_writing(to));
  return store::copy_store(from, *target, selection, progress);
}

Result<void> copy(const CopyOptions& options) {
  TONUS_TRY_ASSIGN(const auto from, open_to_read(options.archive));
  TONUS_TRY_ASSIGN(const auto ids, ids_of(*from, options.sessions));
  ProgressBar bar("samples");
  const auto count = copy_to(*from, options.to, {.only = ids, .without = {}}, progress_of(bar));
  bar.clear();
  if (!count) return count.error();
  print_answer(
      options.is_json,
      {{"to", options.to},
       {"sessions", count->sessions},
       {"trials", count->trials},
       {"samples", count->samples}},
      fmt::format("copied {} sessions, {} trials, {} samples; tonus verify --archive '{}' checks them\n",
                  count->sessions, count->trials, count->samples, options.to));
  return {};
}

struct PruneOptions {
  ArchiveOption archive;
  std::vector<std::string> sessions;
  double older_than_days = 0.0;
  bool is_confirmed = false;
  bool is_json = false;
};

/// The sessions that are named, and those that ended more than so many days ago. One that has not ended is
/// only taken by name.
Result<std::vector<store::SessionRecord>> chosen_sessions(store::Store& store, const PruneOptions& options) {
  TONUS_TRY_ASSIGN(const auto named, ids_of(store, options.sessions));
  std::set<Id> chosen(named.begin(), named.end());
  if (options.older_than_days > 0.0) {
    TONUS_TRY_ASSIGN(const auto certificates, store.session_certificates());
    const double now = 1e-9 * static_cast<double>(SystemClock().utc_ns());
    for (const auto& certificate : certificates) {
      const double age_s = now - 1e-9 * static_cast<double>(certificate.certified_ns);
      if (age_s > options.older_than_days * 86400.0) chosen.insert(certificate.session);
    }
  }
  TONUS_TRY_ASSIGN(const auto all, store::list_sessions(store));
  std::vector<store::SessionRecord> records;
  std::copy_if(all.begin(), all.end(), std::back_inserter(records),
               [&chosen](const auto& record) { return chosen.contains(record.session); });
  return records;
}

std::string text_of(const std::vector<store::SessionRecord>& records, const char* what) {
  std::string text;
  for (const auto& record : records)
    text += fmt::format("{} session {}  {}  {}  {}\n", what, to_hex(record.session).substr(0, 8),
                        record.subject, record.protocol_name, record.started_at);
  return text;
}

nlohmann::json json_of(const std::vector<store::SessionRecord>& records) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& record : records)
    list.push_back({{"session", to_hex(record.session)},
                    {"subject", record.subject},
                    {"protocol", record.protocol_name},
                    {"started_at", record.started_at}});
  return list;
}

Result<void> prune(const PruneOptions& options) {
  if (options.sessions.empty() && options.older_than_days <= 0.0) {
    return fail(ErrorCode::kInvalidArgument,
                "nothing is chosen; expected --older-than DAYS or --session ID, once or more often");
  }
  TONUS_TRY_ASSIGN(const std::string archive, options.archive.name());
  if (is_url(archive)) {
    return fail(
        ErrorCode::kInvalidArgument,
        "an archive on a PostgreSQL server is not pruned; `tonus copy --session ID` copies the sessions "
        "that are to stay into another database");
  }
  std::vector<store::SessionRecord> records;
  {
    TONUS_TRY_ASSIGN(const auto store, open_to_read(options.archive));
    TONUS_TRY_ASSIGN(records, chosen_sessions(*store, options));
  }
  nlohmann::json json{{"sessions", json_of(records)}, {"is_done", false}, {"sessions_left", nullptr}};
  if (records.empty() || !options.is_confirmed) {
    const std::string text =
        records.empty() ? "nothing to remove\n"
                        : text_of(records, "would remove") +
                              fmt::format(
                                  "nothing is changed yet: --yes removes {} sessions for good; tonus "
                                  "backup FILE keeps a copy\n",
                                  records.size());
    print_answer(options.is_json, std::move(json), text);
    return {};
  }
  std::vector<Id> ids;
  ids.reserve(records.size());
  for (const auto& record : records) ids.push_back(record.session);
  if (!options.is_json) std::fputs(text_of(records, "removing").c_str(), stdout);
  ProgressBar bar("samples that stay");
  const auto count = store::prune_sqlite(archive, ids, progress_of(bar));
  bar.clear();
  if (!count) return count.error();
  json["is_done"] = true;
  json["sessions_left"] = count->sessions;
  print_answer(options.is_json, std::move(json),
               fmt::format("removed {} sessions; {} are left\n", ids.size(), count->sessions));
  return {};
}

}  // namespace

void add_copy_commands(CLI::App& app, Command& chosen) {
  auto* copying = app.add_subcommand(
      "copy", "Copies an archive, or some of its sessions, to a new file or an empty PostgreSQL database.");
  auto of_copy = std::make_shared<CopyOptions>();
  copying->add_option("to", of_copy->to, "a new file, or postgresql://USER@HOST/DATABASE")->required();
  copying->add_option("--session", of_copy->sessions,
                      "only this session, by its id or the beginning of it; repeatable");
  add_archive_option(*copying, of_copy->archive);
  add_json_flag(*copying, of_copy->is_json);
  copying->callback([of_copy, &chosen] {
    chosen = [of_copy] {
      const auto done = copy(*of_copy);
      return done ? 0 : runtime::report("tonus copy", done.error());
    };
  });

  auto* pruning = app.add_subcommand(
      "prune",
      "Removes sessions from an archive for good. Without --yes it says which ones and changes nothing.");
  auto of_prune = std::make_shared<PruneOptions>();
  pruning->add_option("--session", of_prune->sessions,
                      "this session, by its id or the beginning of it; repeatable");
  pruning
      ->add_option("--older-than", of_prune->older_than_days,
                   "sessions that ended more than so many days ago")
      ->check(CLI::PositiveNumber);
  pruning->add_flag("--yes", of_prune->is_confirmed, "remove them");
  add_archive_option(*pruning, of_prune->archive);
  add_json_flag(*pruning, of_prune->is_json);
  pruning->callback([of_prune, &chosen] {
    chosen = [of_prune] {
      const auto done = prune(*of_prune);
      return done ? 0 : runtime::report("tonus prune", done.error());
    };
  });
}

}  // namespace tonus::cli
