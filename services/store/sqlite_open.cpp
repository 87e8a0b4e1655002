#include <filesystem>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>

#include "services/core/clock.hpp"
#include "services/store/sqlite_schema.hpp"
#include "services/store/sqlite_store.hpp"

namespace tonus::store {
namespace {

namespace fs = std::filesystem;

/// The path's own faults, before SQLite's less clear words for them.
Result<void> check_path(const std::string& path, bool must_exist) {
  const auto refuse = [&path](ErrorCode code, const std::string& reason) {
    return fail(code, fmt::format("store '{}': {}", path, reason));
  };
  if (path.empty()) return refuse(ErrorCode::kInvalidArgument, "is not allowed; expected a path");
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) return refuse(ErrorCode::kInvalidArgument, "is a folder; expected a file");
  if (fs::exists(status)) {
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

Result<void> prepare_for_writing(Database& database) {
  if (database.is_read_only()) {
    return fail(ErrorCode::kIo,
                fmt::format("store '{}': is read-only; expected a writable file", database.path()));
  }
  TONUS_TRY(schema_version(database));
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
  if (*version == newest_schema_version()) return {};
  return fail(
      ErrorCode::kInvalidArgument,
      fmt::format("store '{}': schema version {} is not allowed; expected {}; tonus-archive migrates it",
                  database.path(), *version, newest_schema_version()));
}

}  // namespace

SqliteStore::SqliteStore(std::optional<StoreLock> lock, Database database)
    : lock_(std::move(lock)), database_(std::move(database)), identity_(identify(database_.path())) {}

Result<std::unique_ptr<SqliteStore>> SqliteStore::open(const std::string& path, Access access) {
  const bool is_for_writing = access == Access::kWrite;
  TONUS_TRY(check_path(path, !is_for_writing));
  const bool is_new = !identify(path).has_value();
  std::optional<StoreLock> lock;
  if (is_for_writing) {
    TONUS_TRY_ASSIGN(auto taken, StoreLock::take(path));
    lock.emplace(std::move(taken));
  }
  const auto open_now = [&]() -> Result<std::unique_ptr<SqliteStore>> {
    TONUS_TRY_ASSIGN(auto database, Database::open(path, is_for_writing ? Database::Mode::kReadWrite
                                                                        : Database::Mode::kReadOnly));
    TONUS_TRY(is_for_writing ? prepare_for_writing(database) : prepare_for_reading(database));
    std::unique_ptr<SqliteStore> store(new SqliteStore(std::move(lock), std::move(database)));
    if (!is_for_writing) return store;
    TONUS_TRY(store->prepare_writing());
    return store;
  };
  auto store = open_now();
  if (!store && is_for_writing && is_new) {
    std::error_code ignored;
    for (const char* suffix : {"", "-wal", "-shm"}) fs::remove(path + suffix, ignored);
  }
  return store;
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
