#include "services/core/record_file.hpp"

#include <algorithm>
#include <cstring>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "services/core/crc32c.hpp"

namespace tonus {
namespace {

struct Header {
  std::uint32_t length;
  std::uint32_t crc;
};
static_assert(sizeof(Header) == 8);

std::uint32_t checksum(std::span<const std::byte> content) {
  // The length takes part: a run of zeros is not a good record of length zero.
  return crc32c(content) ^ static_cast<std::uint32_t>(content.size() * 2654435761U + 1U);
}

/// False: no whole, good record starts there, or it cannot be read.
bool read_record(const RecordStorage& storage, std::uint64_t offset, std::vector<std::byte>& content) {
  Header header{};
  if (!storage.read(offset, std::as_writable_bytes(std::span(&header, 1)))) return false;
  if (header.length > RecordFile::kMaxRecord) return false;
  content.resize(header.length);
  return storage.read(offset + sizeof header, content) && checksum(content) == header.crc;
}

Header header_at(std::span<const std::byte> bytes) {
  Header header{};
  std::memcpy(&header, bytes.data(), sizeof header);
  return header;
}

/// Not an empty one: its header, 0 and 1, is what many contents hold.
bool starts_with_record(std::span<const std::byte> bytes) {
  if (bytes.size() < sizeof(Header)) return false;
  const Header header = header_at(bytes);
  if (header.length == 0 || header.length > RecordFile::kMaxRecord ||
      header.length > bytes.size() - sizeof header)
    return false;
  return checksum(bytes.subspan(sizeof header, header.length)) == header.crc;
}

/// Bytes up to the next good record, or all of them.
std::size_t bytes_before_record(std::span<const std::byte> bytes) {
  std::size_t count = 1;
  while (count < bytes.size() && !starts_with_record(bytes.subspan(count))) ++count;
  return count;
}

/// Whether bytes that no record follows are what an interrupted write leaves.
bool is_torn(std::span<const std::byte> bytes) {
  if (bytes.size() < sizeof(Header)) return true;
  if (std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; })) return true;
  const Header header = header_at(bytes);
  return header.length <= RecordFile::kMaxRecord && header.length > bytes.size() - sizeof header;
}

}  // namespace

Result<RecordFile> RecordFile::open(const std::filesystem::path& path, const Visitor& visit) {
  TONUS_TRY_ASSIGN(auto storage, FileStorage::open(path, FileStorage::Mode::kOpenOrCreate));
  return open(std::move(storage), visit);
}

Result<RecordFile> RecordFile::open(std::unique_ptr<RecordStorage> storage, const Visitor& visit) {
  RecordFile file(std::move(storage));
  TONUS_TRY_ASSIGN(const std::uint64_t length, file.storage_->size());
  std::vector<std::byte> content;
  while (file.size_ < length) {
    if (read_record(*file.storage_, file.size_, content)) {
      if (visit) visit(file.size_, content);
      file.size_ += sizeof(Header) + content.size();
      continue;
    }
    std::vector<std::byte> rest(length - file.size_);
    TONUS_TRY(file.storage_->read(file.size_, rest));
    const std::size_t bad = bytes_before_record(rest);
    if (bad == rest.size() && is_torn(rest)) break;
    file.damage_.push_back({file.size_, bad});
    file.size_ += bad;
  }
  file.torn_bytes_ = length - file.size_;
  if (file.torn_bytes_ > 0) TONUS_TRY(file.storage_->truncate(file.size_));
  return file;
}

Result<std::uint64_t> RecordFile::append(std::span<const std::byte> content) {
  if (content.size() > kMaxRecord) {
    return fail(ErrorCode::kInvalidArgument, fmt::format("{}: a record of {} bytes, at most {} are allowed",
                                                         path().string(), content.size(), kMaxRecord));
  }
  const Header header{static_cast<std::uint32_t>(content.size()), checksum(content)};
  std::vector<std::byte> record(sizeof header + content.size());
  std::memcpy(record.data(), &header, sizeof header);
  if (!content.empty()) std::memcpy(record.data() + sizeof header, content.data(), content.size());
  if (auto written = storage_->write(size_, record); !written) {
    TONUS_TRY(storage_->truncate(size_));
    return written.error();
  }
  return std::exchange(size_, size_ + record.size());
}

Result<std::vector<std::byte>> RecordFile::read(std::uint64_t offset) const {
  std::vector<std::byte> content;
  if (!read_record(*storage_, offset, content)) {
    return fail(ErrorCode::kDataLoss,
                fmt::format("{}: the record at byte {} is damaged", path().string(), offset));
  }
  return content;
}

std::string RecordFile::damage_text() const {
  if (damage_.empty()) return {};
  std::uint64_t bytes = 0;
  for (const DamagedBytes& run : damage_) bytes += run.count;
  return fmt::format(
      "{}: {} bytes in {} place{} are damaged, the first at byte {}: the records there are lost",
      path().string(), bytes, damage_.size(), damage_.size() == 1 ? "" : "s", damage_.front().offset);
}

bool RecordFile::ends_damaged() const {
  return !damage_.empty() && damage_.back().offset + damage_.back().count == size_;
}

Result<void> RecordFile::cut_damaged_end() {
  if (!ends_damaged()) return {};
  TONUS_TRY(storage_->truncate(damage_.back().offset));
  size_ = damage_.back().offset;
  torn_bytes_ += damage_.back().count;
  damage_.pop_back();
  return {};
}

Result<void> RecordFile::rename_to(const std::filesystem::path& path) { return storage_->rename_to(path); }

Result<void> RecordFile::sync() { return storage_->sync(); }

}  // namespace tonus
