#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <spdlog/fmt/fmt.h>

#include "services/cli/answer.hpp"
#include "services/cli/archive_option.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/progress_bar.hpp"
#include "services/core/places.hpp"
#include "services/runtime/options.hpp"
#include "services/store/sqlite_store.hpp"

namespace tonus::cli {
namespace {

struct BackupOptions {
  ArchiveOption archive;
  std::string file;
  bool is_json = false;
};

Result<void> copy(const std::string& from, const std::string& to, const char* what, bool is_json) {
  if (is_url(from) || is_url(to)) {
    return fail(
        ErrorCode::kInvalidArgument,
        "an archive on a PostgreSQL server is not a file: its server's pg_dump and pg_restore copy it "
        "(schema tonus)");
  }
  TONUS_TRY_ASSIGN(const auto source, store::SqliteStore::open(from, store::SqliteStore::Access::kRead));
  ProgressBar bar("pages");
  auto copied =
      source->copy_to(to, [&bar](std::uint64_t done, std::uint64_t total) { bar.show(done, total, ""); });
  bar.clear();
  if (!copied) return copied;
  TONUS_TRY_ASSIGN(const auto made, store::SqliteStore::open(to, store::SqliteStore::Access::kRead));
  TONUS_TRY_ASSIGN(const auto sessions, made->sessions());
  TONUS_TRY_ASSIGN(const auto space, made->space());
  print_answer(
      is_json, {{"from", from}, {"to", to}, {"sessions", sessions.size()}, {"used_bytes", space.used_bytes}},
      fmt::format("{} '{}' to '{}': {} sessions, {:.1f} MB; tonus verify --archive '{}' checks them\n", what,
                  from, to, sessions.size(), 1e-6 * static_cast<double>(space.used_bytes), to));
  return {};
}

Result<void> back_up(const BackupOptions& options) {
  TONUS_TRY_ASSIGN(const std::string archive, options.archive.name());
  return copy(archive, options.file, "copied", options.is_json);
}

Result<void> restore_from(const BackupOptions& options) {
  TONUS_TRY_ASSIGN(const std::string archive, options.archive.name());
  return copy(options.file, archive, "restored", options.is_json);
}

}  // namespace

void add_backup_commands(CLI::App& app, Command& chosen) {
  auto* backup = app.add_subcommand(
      "backup", "Copies the archive, as it is at this moment, to a new file; it may be written meanwhile.");
  auto of_backup = std::make_shared<BackupOptions>();
  backup->add_option("file", of_backup->file, "the new file")->required();
  add_archive_option(*backup, of_backup->archive);
  add_json_flag(*backup, of_backup->is_json);
  backup->callback([of_backup, &chosen] {
    chosen = [of_backup] {
      const auto done = back_up(*of_backup);
      return done ? 0 : runtime::report("tonus backup", done.error());
    };
  });

  auto* restore = app.add_subcommand(
      "restore", "Copies a backup to where the archive's file is missing; nothing is overwritten.");
  auto of_restore = std::make_shared<BackupOptions>();
  restore->add_option("file", of_restore->file, "the backup; it is not changed")->required();
  add_archive_option(*restore, of_restore->archive);
  add_json_flag(*restore, of_restore->is_json);
  restore->callback([of_restore, &chosen] {
    chosen = [of_restore] {
      const auto done = restore_from(*of_restore);
      return done ? 0 : runtime::report("tonus restore", done.error());
    };
  });
}

}  // namespace tonus::cli
