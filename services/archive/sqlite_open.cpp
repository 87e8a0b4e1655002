#include <filesystem>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>

#include "services/archive/sqlite_schema.hpp"
#include "services/archive/sqlite_store.hpp"
#include "services/core/clock.hpp"

namespace tonus::archive {
namespace {

namespace fs = std::filesystem;

/// The path's own faults, before SQLite's less clear words for them.
Result<void> check_path(const std::string& path, bool must_exist) {
  const auto refuse = [&path](ErrorCode code, const std::string& reason) {
    return fail(code, fmt::format("store '{}': {}", path, reason));
  };
  if (path.empty()) return refuse(ErrorCode::kInvalidArgument, "is not allowed: a path is needed");
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) return refuse(ErrorCode::kInvalidArgument, "is a folder: a file is needed");
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
                fmt::format("store '{}': is read-only: it must be writable", database.path()));
  }
  if (const auto version = schema_version(database); !version) return version.error();
  const auto journal = database.text("PRAGMA journal_mode = WAL");
  if (!journal) return journal.error();
  if (*journal != "wal") {
    return fail(ErrorCode::kIo,
                fmt::format("store '{}': journal mode is '{}': a file system that allows 'wal' is needed",
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
      fmt::format("store '{}': schema version {} is not allowed: {} is needed; tonus-archive brings it there",
                  database.path(), *version, newest_schema_version()));
}

}  // namespace

SqliteStore::SqliteStore(std::optional<StoreLock> lock, Database database)
    : lock_(std::move(lock)), database_(std::move(database)), identity_(identify(database_.path())) {}

Result<std::unique_ptr<SqliteStore>> SqliteStore::open(const std::string& path, Access access) {
  const bool is_for_writing = access == Access::kWrite;
  if (auto good = check_path(path, !is_for_writing); !good) return good.error();
  const bool is_new = !identify(path).has_value();
  std::optional<StoreLock> lock;
  if (is_for_writing) {
    auto taken = StoreLock::take(path);
    if (!taken) return taken.error();
    lock.emplace(std::move(*taken));
  }
  const auto open_now = [&]() -> Result<std::unique_ptr<SqliteStore>> {
    auto database =
        Database::open(path, is_for_writing ? Database::Mode::kReadWrite : Database::Mode::kReadOnly);
    if (!database) return database.error();
    auto prepared = is_for_writing ? prepare_for_writing(*database) : prepare_for_reading(*database);
    if (!prepared) return prepared.error();
    std::unique_ptr<SqliteStore> store(new SqliteStore(std::move(lock), std::move(*database)));
    if (!is_for_writing) return store;
    if (auto writing = store->prepare_writing(); !writing) return writing.error();
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
    return fail(ErrorCode::kIo,
                fmt::format("store '{}': its disk cannot be asked: {}", database_.path(), error.message()));
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

}  // namespace tonus::archive
