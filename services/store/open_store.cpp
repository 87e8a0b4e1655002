#include "services/store/open_store.hpp"

#include "services/core/passwords.hpp"
#include "services/core/places.hpp"
#include "services/store/memory_store.hpp"
#include "services/store/postgres_store.hpp"
#include "services/store/sqlite_store.hpp"

namespace tonus::store {
namespace {

constexpr const char* kMemory = ":memory:";

Result<std::unique_ptr<Store>> open(const std::string& name, SqliteStore::Access access) {
  if (name == kMemory) {
    if (access == SqliteStore::Access::kWrite) return std::unique_ptr<Store>(std::make_unique<MemoryStore>());
    return fail(ErrorCode::kInvalidArgument,
                "store ':memory:': holds nothing to read; expected the path of a file");
  }
  if (name.starts_with("postgresql://") || name.starts_with("postgres://")) {
    const bool is_for_writing = access == SqliteStore::Access::kWrite;
    TONUS_TRY_ASSIGN(auto store, PostgresStore::open(name, is_for_writing ? PostgresStore::Access::kWrite
                                                                          : PostgresStore::Access::kRead));
    return std::unique_ptr<Store>(std::move(store));
  }
  if (is_url(name)) {
    return fail(ErrorCode::kInvalidArgument,
                "store '" + without_passwords(name) +
                    "': is not allowed; expected the path of a file, postgresql://... or :memory:");
  }
  TONUS_TRY_ASSIGN(auto store, SqliteStore::open(name, access));
  return std::unique_ptr<Store>(std::move(store));
}

}  // namespace

std::filesystem::path default_store(const std::filesystem::path& data) { return data / "archive.sqlite"; }

Result<std::vector<std::string>> pending_upgrade(const std::string& name) {
  if (name == kMemory || is_url(name)) return std::vector<std::string>();
  return SqliteStore::pending_upgrade(name);
}

Result<std::unique_ptr<Store>> open_store_for_writing(const std::string& name) {
  return open(name, SqliteStore::Access::kWrite);
}

Result<std::unique_ptr<Store>> open_store_for_reading(const std::string& name) {
  return open(name, SqliteStore::Access::kRead);
}

}  // namespace tonus::store
