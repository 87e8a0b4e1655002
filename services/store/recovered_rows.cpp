#include "services/store/recovered_rows.hpp"

#include <algorithm>
#include <span>
#include <spdlog/fmt/fmt.h>

#include "services/core/crc32c.hpp"
#include "services/store/block_header.hpp"

namespace tonus::store {
namespace {

constexpr std::size_t kBlockColumns = 11;
constexpr std::size_t kBlockColumnsBefore =
    10;  // of rows that were written before there were auxiliary channels
constexpr std::size_t kMessageColumns = 7;
constexpr std::size_t kTrialColumns = 21;
constexpr std::size_t kStreamColumns = 7;
constexpr std::size_t kStreamColumnsBefore = 6;  // likewise

const std::vector<std::byte>* bytes_at(const SqliteRow& row, std::size_t column, std::size_t size = 0) {
  const auto* value = std::get_if<std::vector<std::byte>>(&row.values[column]);
  return value != nullptr && (size == 0 || value->size() == size) ? value : nullptr;
}

std::optional<Id> id_at(const SqliteRow& row, std::size_t column) {
  const auto* bytes = bytes_at(row, column, sizeof(Id));
  if (bytes == nullptr) return {};
  Id id;
  std::transform(bytes->begin(), bytes->end(), id.begin(),
                 [](std::byte b) { return std::to_integer<std::uint8_t>(b); });
  return id;
}

std::optional<std::uint64_t> whole_at(const SqliteRow& row, std::size_t column) {
  const auto* value = std::get_if<std::int64_t>(&row.values[column]);
  if (value == nullptr) return {};
  return static_cast<std::uint64_t>(*value);
}

bool begins_with_key(const SqliteRow& row) { return std::holds_alternative<std::monostate>(row.values[0]); }

/// A row of `blocks`; its checksum is not checked yet.
bool is_block(const SqliteRow& row) {
  const bool has_columns = row.values.size() == kBlockColumns ? whole_at(row, 10).has_value()
                                                              : row.values.size() == kBlockColumnsBefore;
  return has_columns && begins_with_key(row) && whole_at(row, 2) && whole_at(row, 3) && id_at(row, 4) &&
         id_at(row, 5) && whole_at(row, 6) && whole_at(row, 7) && whole_at(row, 8) &&
         bytes_at(row, 9) != nullptr;
}

bool is_message(const SqliteRow& row) {
  return row.values.size() == kMessageColumns && begins_with_key(row) &&
         std::holds_alternative<std::string>(row.values[1]) && id_at(row, 2) && id_at(row, 3) &&
         whole_at(row, 4) && whole_at(row, 5) && bytes_at(row, 6) != nullptr;
}

/// What the content says of itself; none where it is not what the column says.
std::optional<Block> header_of(std::span<const std::byte> payload, bool is_auxiliary) {
  if (is_auxiliary) {
    auto header = read_auxiliary_header(payload);
    return header ? std::optional(std::move(header->block)) : std::nullopt;
  }
  auto header = read_block_header(payload);
  return header ? std::optional(std::move(*header)) : std::nullopt;
}

/// None where its content is not what its checksum was made of, or neither samples nor auxiliary values.
std::optional<Block> block_of(const SqliteRow& row) {
  const auto* payload = bytes_at(row, 9);
  if (crc32c(*payload) != *whole_at(row, 8)) return {};
  const bool is_auxiliary = row.values.size() == kBlockColumns && *whole_at(row, 10) != 0;
  auto block = header_of(*payload, is_auxiliary);
  if (!block) return {};
  block->session = *id_at(row, 4);
  block->trial = *id_at(row, 5);
  block->is_resent = *whole_at(row, 6) != 0;
  block->received_ns = *whole_at(row, 7);
  block->checksum = static_cast<std::uint32_t>(*whole_at(row, 8));
  block->payload = std::make_shared<const std::vector<std::byte>>(*payload);
  return block;
}

std::optional<Message> message_of(const SqliteRow& row) {
  const auto* payload = bytes_at(row, 6);
  if (crc32c(*payload) != *whole_at(row, 5)) return {};
  return Message{std::get<std::string>(row.values[1]),
                 *id_at(row, 2),
                 *id_at(row, 3),
                 *whole_at(row, 4),
                 static_cast<std::uint32_t>(*whole_at(row, 5)),
                 std::make_shared<const std::vector<std::byte>>(*payload)};
}

void take_trial(const SqliteRow& row, RecoveredRows& rows) {
  const auto id = id_at(row, 0);
  if (!id) return;
  TrialRecord trial;
  trial.certified_ns = whole_at(row, 15).value_or(0);
  trial.certificate.resent = whole_at(row, 18).value_or(0);
  trial.certificate.duplicated = whole_at(row, 19).value_or(0);
  rows.trials[*id] = trial;
}

void take_stream(const SqliteRow& row, RecoveredRows& rows) {
  const auto rig = id_at(row, 1);
  const auto epoch = whole_at(row, 2);
  if (!rig || !epoch || !begins_with_key(row)) return;
  StreamRecord stream;
  stream.key = {*rig, *epoch};
  stream.origin = whole_at(row, 3).value_or(0);
  stream.resent = whole_at(row, 4).value_or(0);
  stream.duplicated = whole_at(row, 5).value_or(0);
  if (row.values.size() == kStreamColumns)
    stream.auxiliary_values = static_cast<std::uint32_t>(whole_at(row, 6).value_or(0));
  rows.streams[stream.key] = stream;
}

}  // namespace

Result<RecoveredRows> find_rows(SqlitePages& pages, const Progress& progress) {
  RecoveredRows rows;
  TONUS_TRY(pages.visit_rows(
      [&](const SqliteRow& row, const SqliteCell& cell) {
        if (is_block(row)) {
          rows.last_block = std::max(rows.last_block, row.rowid);
          if (block_of(row)) rows.blocks.emplace(row.rowid, cell);
        } else if (is_message(row)) {
          rows.last_message = std::max(rows.last_message, row.rowid);
          if (message_of(row)) {
            rows.messages.emplace(row.rowid, cell);
          } else {
            rows.damaged_messages[row.rowid] =
                fmt::format("{}, key {}", std::get<std::string>(row.values[1]), to_hex(*id_at(row, 2)));
          }
        } else if (row.values.size() == kTrialColumns) {
          take_trial(row, rows);
        } else if (row.values.size() == kStreamColumns || row.values.size() == kStreamColumnsBefore) {
          take_stream(row, rows);
        }
      },
      progress));
  return rows;
}

std::optional<Block> read_block(SqlitePages& pages, const SqliteCell& cell) {
  const auto row = pages.read(cell);
  return row && is_block(*row) ? block_of(*row) : std::nullopt;
}

std::optional<Message> read_message(SqlitePages& pages, const SqliteCell& cell) {
  const auto row = pages.read(cell);
  return row && is_message(*row) ? message_of(*row) : std::nullopt;
}

}  // namespace tonus::store
