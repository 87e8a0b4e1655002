#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/result.hpp"
#include "services/store/sqlite.hpp"

namespace tonus::store {

/// "tonu": marks an SQLite file as one of ours (PRAGMA application_id).
inline constexpr std::int64_t kApplicationId = 0x746F6E75;

/// Version of the tables that this program writes.
[[nodiscard]] int newest_schema_version();

/// A table as it is in the newest version, for the documentation.
struct SchemaTable {
  struct Column {
    std::string name;
    std::string type;  ///< "BLOB"
  };
  std::string name;
  std::vector<Column> columns;
};
[[nodiscard]] Result<std::vector<SchemaTable>> tables_of_schema();

/// Version of the file's tables; 0: an empty file. kInvalidArgument: not a file of ours, or a newer version.
[[nodiscard]] Result<int> schema_version(Database& database);

/// What migrate() would do to tables of that version, a step each: "2: certificates of sessions".
[[nodiscard]] std::vector<std::string> steps_after(int version);

/// Brings the tables to the newest version, each step in a transaction of its own, and notes it in
/// schema_migrations. Makes the indexes that are missing.
[[nodiscard]] Result<void> migrate(Database& database, std::uint64_t utc_ns);

}  // namespace tonus::store
