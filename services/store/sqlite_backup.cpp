// An archive's copy while it is written.

#include <spdlog/fmt/fmt.h>
#include <sqlite3.h>

#include "services/store/sqlite_store.hpp"
#include "services/store/store_file.hpp"

namespace tonus::store {
namespace {

constexpr int kPagesAtOnce = 1024;

Error refuse(ErrorCode code, const std::string& target, const std::string& why) {
  return fail(code, fmt::format("'{}': {}", target, why));
}

/// One file without a log beside it, which says of itself that nobody writes it.
Result<void> bring_to_rest(Database& copy) {
  TONUS_TRY_ASSIGN(const auto journal, copy.text("PRAGMA journal_mode = DELETE"));
  if (journal != "delete")
    return refuse(ErrorCode::kIo, copy.path(), fmt::format("journal mode '{}' stays in force", journal));
  TONUS_TRY(copy.run("PRAGMA user_version = 0"));
  TONUS_TRY_ASSIGN(const auto found, copy.text("PRAGMA quick_check(1)"));
  if (found == "ok") return {};
  return refuse(
      ErrorCode::kDataLoss, copy.path(),
      fmt::format("is damaged, as its source is: {}; `tonus recover` copies what can be read", found));
}

}  // namespace

Result<void> SqliteStore::copy_pages(Database& copy,
                                     const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  sqlite3_backup* backup = sqlite3_backup_init(copy.get(), "main", database_.get(), "main");
  if (backup == nullptr) return copy.error("copying the archive");
  int code = SQLITE_OK;
  while (code == SQLITE_OK) {
    code = sqlite3_backup_step(backup, kPagesAtOnce);
    const auto total = static_cast<std::uint64_t>(sqlite3_backup_pagecount(backup));
    if (progress) progress(total - static_cast<std::uint64_t>(sqlite3_backup_remaining(backup)), total);
  }
  const bool is_done = code == SQLITE_DONE;
  if (sqlite3_backup_finish(backup) != SQLITE_OK || !is_done) return copy.error("copying the archive");
  return {};
}

Result<void> SqliteStore::copy_to(const std::string& target,
                                  const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  return make_store_file(target, [&](const std::string& partial) -> Result<void> {
    TONUS_TRY_ASSIGN(auto copy, Database::open(partial, Database::Mode::kReadWrite));
    // An open read transaction holds this moment fast: what is committed from now on is not seen.
    TONUS_TRY(database_.run("BEGIN"));
    auto pages = database_.number("SELECT count(*) FROM sqlite_master");
    auto done = pages ? copy_pages(copy, progress) : Result<void>(pages.error());
    const auto ended = database_.run("COMMIT");
    if (!done) return done;
    if (!ended) return ended.error();
    TONUS_TRY(check_resting());
    return bring_to_rest(copy);
  });
}

}  // namespace tonus::store
