#include "services/scheduler/journal.hpp"

#include <iterator>
#include <spdlog/fmt/fmt.h>
#include <string>
#include <utility>

namespace tonus::scheduler {
namespace {

constexpr std::size_t kNumberBytes = 4;

std::uint32_t number_of(std::string_view record) {
  std::uint32_t value = 0;
  for (std::size_t i = kNumberBytes; i-- > 0;) value = value << 8 | static_cast<std::uint8_t>(record[i]);
  return value;
}

/// What a good record says: of record 0 that its contract is this program's, of the others the decisions.
Result<std::vector<Record>> decisions_in(std::string_view record, std::uint32_t number,
                                         std::string_view contract) {
  if (record.size() < kNumberBytes || number_of(record) != number)
    return fail(ErrorCode::kDataLoss, fmt::format("journal: record {} is missing", number));
  const std::string_view content = record.substr(kNumberBytes);
  if (number > 0) return decode_records(content);
  if (content == contract) return std::vector<Record>{};
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("journal: written with contract {}, this program has {}", content, contract));
}

}  // namespace

std::string numbered(std::uint32_t number, std::string_view content) {
  std::string record;
  for (unsigned shift = 0; shift < 32; shift += 8)
    record.push_back(static_cast<char>(number >> shift & 0xffU));
  record += content;
  return record;
}

Result<Journal> Journal::create(std::unique_ptr<RecordStorage> storage, std::string_view contract) {
  TONUS_TRY_ASSIGN(auto file, RecordFile::open(std::move(storage), {}));
  Journal journal(std::move(file));
  TONUS_TRY(journal.append_numbered(contract));
  return journal;
}

Result<Journal::Opened> Journal::open(std::unique_ptr<RecordStorage> storage, std::string_view contract) {
  std::vector<std::string> contents;
  const auto keep = [&contents](std::uint64_t, std::span<const std::byte> content) {
    contents.emplace_back(reinterpret_cast<const char*>(content.data()), content.size());
  };
  TONUS_TRY_ASSIGN(auto file, RecordFile::open(std::move(storage), keep));
  if (const auto& damage = file.damage(); damage.size() > (file.ends_damaged() ? 1U : 0U))
    return fail(ErrorCode::kDataLoss, fmt::format("journal: damaged at byte {}", damage[0].offset));

  Journal journal(std::move(file));
  std::vector<Record> records;
  for (const auto& content : contents) {
    TONUS_TRY_ASSIGN(auto more, decisions_in(content, journal.next_number_++, contract));
    std::move(more.begin(), more.end(), std::back_inserter(records));
  }
  TONUS_TRY(journal.file_.cut_damaged_end());
  if (journal.file_.torn_bytes() > 0) TONUS_TRY(journal.file_.sync());
  const std::size_t cut = journal.file_.torn_bytes();
  if (contents.empty()) TONUS_TRY(journal.append_numbered(contract));  // torn before anything was promised
  return Opened{std::move(journal), std::move(records), cut};
}

Result<void> Journal::append(const std::vector<Record>& records) {
  if (records.empty()) return {};
  TONUS_TRY_ASSIGN(const auto content, encode_records(records));
  return append_numbered(content);
}

Result<void> Journal::append_numbered(std::string_view content) {
  if (has_failed_)
    return fail(ErrorCode::kIo, "journal: an earlier write failed; the scheduler has to start anew");
  const std::string record = numbered(next_number_, content);
  auto written = file_.append(std::as_bytes(std::span(record)));
  if (!written && written.error().code == ErrorCode::kInvalidArgument) return written.error();
  Result<void> good = written ? file_.sync() : Result<void>(written.error());
  has_failed_ = !good;
  ++next_number_;
  return good;
}

}  // namespace tonus::scheduler
