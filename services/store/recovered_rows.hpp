#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "services/core/progress.hpp"
#include "services/core/result.hpp"
#include "services/store/records.hpp"
#include "services/store/sqlite_pages.hpp"

namespace tonus::store {

/// Which rows of a damaged archive are whole: those that look like a block or a message and have the right
/// checksum. A row is known by its number and place, so that a large file need not fit into memory.
struct RecoveredRows {
  std::map<std::int64_t, SqliteCell> blocks;
  std::map<std::int64_t, SqliteCell> messages;
  std::map<std::int64_t, std::string> damaged_messages;  ///< By number: topic and key.
  std::int64_t last_block = 0;                ///< Largest number that was seen, of damaged rows too.
  std::int64_t last_message = 0;              ///< Likewise.
  std::map<Id, TrialRecord> trials;           ///< Counts that only the table has.
  std::map<StreamKey, StreamRecord> streams;  ///< Likewise.

  [[nodiscard]] std::size_t rows() const { return blocks.size() + messages.size(); }
};

[[nodiscard]] Result<RecoveredRows> find_rows(SqlitePages& pages, const Progress& progress);

/// None where the row is not what its checksum was made of, or a block's content is not samples.
[[nodiscard]] std::optional<Block> read_block(SqlitePages& pages, const SqliteCell& cell);
[[nodiscard]] std::optional<Message> read_message(SqlitePages& pages, const SqliteCell& cell);

}  // namespace tonus::store
