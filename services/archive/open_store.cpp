#include "services/archive/open_store.hpp"

#include "services/archive/memory_store.hpp"
#include "services/archive/postgres_store.hpp"
#include "services/archive/sqlite_store.hpp"
#include "services/core/passwords.hpp"

namespace tonus::archive {
namespace {

constexpr const char* kMemory = ":memory:";

Result<std::unique_ptr<Store>> open(const std::string& name, SqliteStore::Access access) {
  if (name == kMemory) {
    if (access == SqliteStore::Access::kWrite) return std::unique_ptr<Store>(std::make_unique<MemoryStore>());
    return fail(ErrorCode::kInvalidArgument,
                "store ':memory:': holds nothing to read: the path of a file is needed");
  }
  if (name.starts_with("postgresql://") || name.starts_with("postgres://")) {
    const bool is_for_writing = access == SqliteStore::Access::kWrite;
    auto store = PostgresStore::open(
        name, is_for_writing ? PostgresStore::Access::kWrite : PostgresStore::Access::kRead);
    if (!store) return store.error();
    return std::unique_ptr<Store>(std::move(*store));
  }
  if (name.find("://") != std::string::npos) {
    return fail(ErrorCode::kInvalidArgument,
                "store '" + without_passwords(name) +
                    "': is not allowed: the path of a file, postgresql://... or :memory: is needed");
  }
  auto store = SqliteStore::open(name, access);
  if (!store) return store.error();
  return std::unique_ptr<Store>(std::move(*store));
}

}  // namespace

Result<std::unique_ptr<Store>> open_store_for_writing(const std::string& name) {
  return open(name, SqliteStore::Access::kWrite);
}

Result<std::unique_ptr<Store>> open_store_for_reading(const std::string& name) {
  return open(name, SqliteStore::Access::kRead);
}

}  // namespace tonus::archive
