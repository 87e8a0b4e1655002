#include <array>
#include <filesystem>
#include <fstream>
#include <spdlog/fmt/fmt.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include "services/core/clock.hpp"
#include "services/core/folder.hpp"
#include "services/store/sqlite_schema.hpp"
#include "services/store/sqlite_store.hpp"

namespace tonus::store {
namespace {

namespace fs = std::filesystem;

/// user_version of a file whose newest data are in the log beside it.
constexpr std::uint32_t kBeingWritten = 1;

/// The path's own faults, before SQLite's less clear words for them.
Result<void> check_path(const std::string& path, bool must_exist) {
  const auto refuse = [&path](ErrorCode code, const std::string& reason) {
    return fail(code, fmt::format("store '{}': {}", path, reason));
  };
  if (path.empty()) return refuse(ErrorCode::kInvalidArgument, "is not allowed; expected a path");
  const auto is_there = is_present(path);
  if (!is_there) return fail(is_there.error().code, "store " + is_there.error().message);
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) return refuse(ErrorCode::kInvalidArgument, "is a folder; expected a file");
  if (*is_there) {
    if (!fs::is_regular_file(status)) return refuse(ErrorCode::kInvalidArgument, "is not a regular file");
    return {};
  }
  if (must_exist) return refuse(ErrorCode::kNotFound, "no such file");
  const fs::path folder = fs::absolute(path, error).parent_path();
  if (!fs::is_directory(folder, error)) {
    return refuse(ErrorCode::kNotFound, fmt::format("its folder '{}' does not exist", folder.string()));
  }
  return {};
}

std::uint32_t big_endian(const char* bytes, int count) {
  std::uint32_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8U | static_cast<unsigned char>(bytes[i]);
  return value;
}

bool has_log(const std::string& path) {
  std::error_code error;
  return fs::exists(path + "-wal", error) || error;
}

/// True where the log holds something, or where that cannot be seen.
bool has_log_content(const std::string& path) {
  std::error_code error;
  const auto size = fs::file_size(path + "-wal", error);
  return error ? has_log(path) : size > 0;
}

/// The header's own account of the file, where no log beside it may say otherwise.
Result<void> check_header(const std::string& path) {
  std::array<char, 100> header{};
  std::ifstream file(path, std::ios::binary);
  if (!file.read(header.data(), header.size()) || std::string_view(header.data()) != "SQLite format 3")
    return {};
  const std::uint32_t stated_page = big_endian(&header[16], 2);
  const std::uint64_t page = stated_page == 1 ? 65536 : stated_page;
  const std::uint64_t pages = big_endian(&header[28], 4);
  const bool is_valid = big_endian(&header[24], 4) == big_endian(&header[92], 4);
  std::error_code error;
  const std::uint64_t size = fs::file_size(path, error);
  if (!has_log(path) && is_valid && !error && page > 0 && size < pages * page) {
    return fail(ErrorCode::kDataLoss,
                fmt::format("store '{}': is cut off: has {} of {} bytes; `tonus recover` copies what is left",
                            path, size, pages * page));
  }
  if (!has_log(path) && big_endian(&header[60], 4) == kBeingWritten) {
    return fail(
        ErrorCode::kDataLoss,
        fmt::format("store '{0}': was copied or moved while it was written, without its log: the newest "
                    "data are missing; expected '{0}-wal' beside it (`tonus recover` copies what is "
                    "here)",
                    path));
  }
  return {};
}

Result<void> refuse_empty(const Database& database) {
  return fail(
      ErrorCode::kDataLoss,
      fmt::format("store '{0}': holds no table: a new file that was never used, or a copy without its log "
                  "'{0}-wal'; expected an archive, or a name of which there is no file",
                  database.path()));
}

Result<void> prepare_for_writing(Database& database, bool is_new) {
  if (database.is_read_only()) {
    return fail(ErrorCode::kIo,
                fmt::format("store '{}': is read-only; expected a writable file", database.path()));
  }
  TONUS_TRY_ASSIGN(const int version, schema_version(database));
  if (version == 0 && !is_new) return refuse_empty(database);
  const auto journal = database.text("PRAGMA journal_mode = WAL");
  if (!journal) return journal.error();
  if (*journal != "wal") {
    return fail(ErrorCode::kIo, fmt::format("store '{}': journal mode '{}' is not allowed; expected 'wal', "
                                            "which its file system must support",
                                            database.path(), *journal));
  }
  if (auto set =
          database.run("PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON; PRAGMA temp_store = MEMORY");
      !set) {
    return set;
  }
  return migrate(database, SystemClock().utc_ns());
}

Result<void> prepare_for_reading(Database& database) {
  const auto version = schema_version(database);
  if (!version) return version.error();
  if (*version == 0) return refuse_empty(database);
  if (*version == newest_schema_version()) return {};
  return fail(
      ErrorCode::kInvalidArgument,
      fmt::format("store '{}': schema version {} is not allowed; expected {}; tonus-archive migrates it",
                  database.path(), *version, newest_schema_version()));
}

/// Whether the log stays beside the file when the last connection ends.
void keep_log_on_close(const Database& database, bool is_kept) {
  static_cast<void>(
      sqlite3_db_config(database.get(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, is_kept ? 1 : 0, nullptr));
}

}  // namespace

SqliteStore::SqliteStore(std::optional<StoreLock> lock, Database database)
    : lock_(std::move(lock)), database_(std::move(database)), identity_(identify(database_.path())) {}

SqliteStore::~SqliteStore() {
  if (writing_.empty() || !check_file()) return;
  // The last commit; with it all go into the file, also where a reader keeps the log from being removed.
  if (!database_.run("PRAGMA user_version = 0; PRAGMA wal_checkpoint(TRUNCATE)")) return;
  keep_log_on_close(database_, false);
}

Result<void> SqliteStore::begin_writing(bool is_new) {
  TONUS_TRY(prepare_for_writing(database_, is_new));
  keep_log_on_close(database_, true);  // a file that stays marked, on a disk that fails, keeps its log
  const std::string mark = fmt::format("PRAGMA user_version = {}", kBeingWritten);
  TONUS_TRY(database_.run(mark.c_str()));
  TONUS_TRY(database_.run("PRAGMA wal_checkpoint(TRUNCATE)"));  // the mark is in the file itself
  return prepare_writing();
}

Result<std::unique_ptr<SqliteStore>> SqliteStore::open(const std::string& path, Access access) {
  TONUS_TRY(check_path(path, access == Access::kRead));
  TONUS_TRY(check_header(path));
  return access == Access::kWrite ? open_for_writing(path) : open_for_reading(path);
}

Result<std::vector<std::string>> SqliteStore::pending_upgrade(const std::string& path) {
  if (!identify(path)) return std::vector<std::string>();
  TONUS_TRY(check_path(path, true));
  const bool is_resting = !StoreLock::is_taken(path) && !has_log_content(path);
  TONUS_TRY_ASSIGN(auto database,
                   Database::open(path, is_resting ? Database::Mode::kResting : Database::Mode::kReadOnly));
  TONUS_TRY_ASSIGN(const int version, schema_version(database));
  return version == 0 ? std::vector<std::string>() : steps_after(version);
}

Result<std::unique_ptr<SqliteStore>> SqliteStore::open_for_writing(const std::string& path) {
  std::error_code ignored;
  const bool is_new = !identify(path).has_value();
  const bool is_empty = is_new || (fs::file_size(path, ignored) == 0 && !has_log_content(path));
  TONUS_TRY_ASSIGN(auto lock, StoreLock::take(path));
  const auto open_now = [&]() -> Result<std::unique_ptr<SqliteStore>> {
    TONUS_TRY_ASSIGN(auto database, Database::open(path, Database::Mode::kReadWrite));
    std::unique_ptr<SqliteStore> store(new SqliteStore(std::move(lock), std::move(database)));
    TONUS_TRY(store->begin_writing(is_empty));
    return store;
  };
  auto store = open_now();
  if (!store && is_new) {
    for (const char* suffix : {"", "-wal", "-shm"}) fs::remove(path + suffix, ignored);
  }
  return store;
}

Result<std::unique_ptr<SqliteStore>> SqliteStore::open_for_reading(const std::string& path) {
  struct stat info {};
  const bool is_owner = ::stat(path.c_str(), &info) == 0 && info.st_uid == ::geteuid();
  const bool is_written = StoreLock::is_taken(path);
  const bool is_resting = !is_written && !has_log_content(path);
  if (!is_written && !is_resting && !(is_owner && ::access(path.c_str(), W_OK) == 0)) {
    return fail(
        ErrorCode::kUnavailable,
        fmt::format("store '{}': was not closed in an orderly way, and the newest is in its log: its owner "
                    "may read it, or start tonus-archive, which closes it; `tonus recover` copies both",
                    path));
  }
  std::error_code error;
  const auto since = fs::last_write_time(path, error);
  TONUS_TRY_ASSIGN(auto database,
                   Database::open(path, is_resting ? Database::Mode::kResting : Database::Mode::kReadOnly));
  TONUS_TRY(prepare_for_reading(database));
  std::unique_ptr<SqliteStore> store(new SqliteStore(std::nullopt, std::move(database)));
  if (is_resting) store->rests_since_ = since;
  return store;
}

Result<void> SqliteStore::check_resting() const {
  std::error_code error;
  if (!rests_since_ || fs::last_write_time(database_.path(), error) == *rests_since_) return {};
  return fail(
      ErrorCode::kUnavailable,
      fmt::format("store '{}': began to be written while it was read; read it again", database_.path()));
}

std::optional<SqliteStore::FileIdentity> SqliteStore::identify(const std::string& path) {
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0) return {};
  return FileIdentity{info.st_dev, info.st_ino};
}

Result<StoreSpace> SqliteStore::space() {
  StoreSpace space;
  std::error_code error;
  const auto disk = fs::space(fs::absolute(database_.path(), error).parent_path(), error);
  if (error) {
    return fail(ErrorCode::kIo, fmt::format("store '{}': the space on its disk cannot be determined: {}",
                                            database_.path(), error.message()));
  }
  space.free_bytes = disk.available;
  for (const char* suffix : {"", "-wal", "-shm"}) {
    const auto bytes = fs::file_size(database_.path() + suffix, error);
    if (!error) space.used_bytes += bytes;
  }
  return space;
}

Result<void> SqliteStore::check_file() const {
  if (identify(database_.path()) == identity_) return {};
  return fail(
      ErrorCode::kIo,
      fmt::format("store '{}': was removed or replaced while it is in use: what is written would be lost",
                  database_.path()));
}

}  // namespace tonus::store
