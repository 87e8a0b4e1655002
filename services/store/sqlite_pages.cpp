#include "services/store/sqlite_pages.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

namespace tonus::store {
namespace {

constexpr std::size_t kHeaderBytes = 100;
constexpr std::byte kTableLeaf{0x0D};
constexpr std::string_view kMagic("SQLite format 3\0", 16);
constexpr std::size_t kLogHeaderBytes = 32;
constexpr std::size_t kFrameHeaderBytes = 24;
constexpr std::uint64_t kLargestRow = 64U << 20U;  // an archive's rows are far below
constexpr std::size_t kMostColumns = 64;           // likewise

std::uint32_t big_endian(std::span<const std::byte> bytes) {
  std::uint32_t value = 0;
  for (const std::byte b : bytes) value = value << 8U | std::to_integer<std::uint32_t>(b);
  return value;
}

bool is_page_size(std::uint32_t size) { return size >= 512 && size <= 65536 && std::has_single_bit(size); }

/// A variable-length integer; moves `at` behind it. None where the bytes end first.
std::optional<std::uint64_t> varint(std::span<const std::byte> bytes, std::size_t& at) {
  constexpr std::size_t kLongest = 9;
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < kLongest; ++i) {
    if (at >= bytes.size()) return {};
    const auto b = std::to_integer<std::uint64_t>(bytes[at++]);
    if (i == kLongest - 1) return value << 8U | b;
    value = value << 7U | (b & 0x7FU);
    if ((b & 0x80U) == 0) return value;
  }
  return value;
}

/// Octets of a value of this serial type.
std::uint64_t size_of(std::uint64_t type) {
  constexpr std::array<std::uint64_t, 12> kSizes{0, 1, 2, 3, 4, 6, 8, 8, 0, 0, 0, 0};
  return type < kSizes.size() ? kSizes[type] : (type - 12) / 2;
}

SqliteValue value_of(std::uint64_t type, std::span<const std::byte> bytes) {
  if (type == 0) return std::monostate{};
  if (type == 8 || type == 9) return static_cast<std::int64_t>(type - 8);
  if (type >= 12) {
    if (type % 2 == 0) return std::vector<std::byte>(bytes.begin(), bytes.end());
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  std::uint64_t raw = 0;
  for (const std::byte b : bytes) raw = raw << 8U | std::to_integer<std::uint64_t>(b);
  if (type == 7) return std::bit_cast<double>(raw);
  const unsigned unused = 64U - 8U * static_cast<unsigned>(bytes.size());
  return static_cast<std::int64_t>(raw << unused) >> unused;  // keeps the sign
}

}  // namespace

Result<SqlitePages> SqlitePages::open(const std::filesystem::path& path,
                                      std::optional<std::uint32_t> page_size) {
  auto file = open_for_reading(path);
  if (!file) return file.error();
  SqlitePages pages(*std::move(file));
  std::array<std::byte, kHeaderBytes> header{};
  if (::pread(pages.file_.descriptor.get(), header.data(), header.size(), 0) ==
      static_cast<ssize_t>(header.size())) {
    std::uint32_t size = big_endian(std::span(header).subspan(16, 2));
    if (size == 1) size = 65536;
    pages.has_header_ = std::memcmp(header.data(), kMagic.data(), kMagic.size()) == 0 && is_page_size(size);
    if (page_size) {
      pages.page_size_ = pages.usable_ = *page_size;
    } else if (pages.has_header_) {
      pages.page_size_ = size;
      const auto reserved = std::to_integer<std::uint32_t>(header[20]);
      pages.usable_ = size - (size - reserved >= 480 ? reserved : 0);
      pages.pages_in_header_ = big_endian(std::span(header).subspan(28, 4));
    }
  }
  pages.pages_ = (pages.file_.size + pages.page_size_ - 1) / pages.page_size_;
  pages.read_log(path.string() + "-wal");
  if (!pages.log_.empty()) pages.pages_ = std::max(pages.pages_, pages.log_.rbegin()->first);
  return pages;
}

void SqlitePages::read_log(const std::filesystem::path& path) {
  std::ifstream log(path, std::ios::binary);
  std::array<std::byte, kLogHeaderBytes> header{};
  if (!log.read(reinterpret_cast<char*>(header.data()), header.size())) return;
  const std::uint32_t magic = big_endian(std::span(header).first(4));
  constexpr std::uint32_t kLogMagic = 0x377F0682;
  const std::uint32_t size = big_endian(std::span(header).subspan(8, 4));
  if ((magic & ~1U) != kLogMagic || !is_page_size(size)) return;
  if (size != page_size_) return;
  pages_ = (file_.size + page_size_ - 1) / page_size_;
  std::map<std::uint64_t, std::vector<std::byte>> uncommitted;
  std::array<std::byte, kFrameHeaderBytes> frame{};
  std::vector<std::byte> page(page_size_);
  while (log.read(reinterpret_cast<char*>(frame.data()), frame.size()) &&
         log.read(reinterpret_cast<char*>(page.data()), page_size_)) {
    // Frames of an earlier round of the log have other salts.
    if (!std::equal(frame.begin() + 8, frame.begin() + 16, header.begin() + 16)) break;
    const std::uint32_t number = big_endian(std::span(frame).first(4));
    if (number == 0) break;
    uncommitted[number] = page;
    if (big_endian(std::span(frame).subspan(4, 4)) == 0) continue;
    for (auto& [n, content] : uncommitted) log_[n] = std::move(content);
    uncommitted.clear();
  }
}

bool SqlitePages::load(std::uint64_t number, std::vector<std::byte>& page) const {
  if (number == 0 || number > pages_) return false;
  if (const auto logged = log_.find(number); logged != log_.end()) {
    page = logged->second;
    return true;
  }
  page.assign(page_size_, std::byte{0});
  const auto read =
      ::pread(file_.descriptor.get(), page.data(), page_size_, static_cast<off_t>((number - 1) * page_size_));
  return read > 0;  // the last page may be cut off
}

Result<void> SqlitePages::visit_rows(const Visitor& visit,
                                     const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  leaves_ = bad_cells_ = 0;
  std::vector<std::byte> page;
  constexpr std::size_t kLeafHeaderBytes = 8;
  for (std::uint64_t number = 1; number <= pages_; ++number) {
    if (progress && number % 256 == 0) progress(number, pages_);
    if (!load(number, page)) continue;
    const std::size_t base = number == 1 ? kHeaderBytes : 0;
    if (page[base] != kTableLeaf) continue;
    ++leaves_;
    const std::size_t cells = big_endian(std::span(page).subspan(base + 3, 2));
    for (std::size_t i = 0; i < cells; ++i) {
      const std::size_t at = base + kLeafHeaderBytes + 2 * i;
      if (at + 2 > page.size()) break;
      const std::size_t offset = big_endian(std::span(page).subspan(at, 2));
      const auto row = parse(page, offset);
      if (row) {
        visit(*row, {static_cast<std::uint32_t>(number), static_cast<std::uint16_t>(offset)});
      } else {
        ++bad_cells_;
      }
    }
  }
  if (progress) progress(pages_, pages_);
  return {};
}

std::optional<SqliteRow> SqlitePages::read(const SqliteCell& cell) {
  std::vector<std::byte> page;
  if (!load(cell.page, page)) return {};
  return parse(page, cell.offset);
}

std::optional<std::vector<std::byte>> SqlitePages::payload_at(std::span<const std::byte> page,
                                                              std::size_t offset, std::uint64_t size) const {
  // Section 1.6: how much of a row lies on its own page.
  const std::uint64_t U = usable_;
  const std::uint64_t X = U - 35;
  const std::uint64_t M = (U - 12) * 32 / 255 - 23;
  const std::uint64_t K = M + (size - std::min(size, M)) % (U - 4);
  const std::uint64_t local = size <= X ? size : (K <= X ? K : M);
  const bool is_split = local < size;
  if (offset + local + (is_split ? 4 : 0) > U) return {};
  std::vector<std::byte> payload(page.begin() + static_cast<std::ptrdiff_t>(offset),
                                 page.begin() + static_cast<std::ptrdiff_t>(offset + local));
  if (!is_split) return payload;
  std::uint64_t next = big_endian(page.subspan(offset + local, 4));
  std::vector<std::byte> overflow;
  while (payload.size() < size) {
    if (!load(next, overflow)) return {};
    const std::uint64_t part = std::min<std::uint64_t>(size - payload.size(), U - 4);
    payload.insert(payload.end(), overflow.begin() + 4,
                   overflow.begin() + 4 + static_cast<std::ptrdiff_t>(part));
    next = big_endian(std::span(overflow).first(4));
  }
  return payload;
}

std::optional<SqliteRow> SqlitePages::parse(std::span<const std::byte> page, std::size_t offset) const {
  std::size_t at = offset;
  const auto size = varint(page, at);
  if (!size || *size == 0 || *size > kLargestRow || *size > pages_ * page_size_) return {};
  const auto rowid = varint(page, at);
  if (!rowid) return {};
  const auto payload = payload_at(page, at, *size);
  if (!payload) return {};

  // Section 2.1: the row's header gives the type of each value, then come the values.
  std::size_t header = 0;
  const auto header_size = varint(*payload, header);
  if (!header_size || *header_size > payload->size()) return {};
  SqliteRow row;
  row.rowid = static_cast<std::int64_t>(*rowid);
  std::size_t body = *header_size;
  while (header < *header_size) {
    const auto type = varint(std::span(*payload).first(*header_size), header);
    if (!type || *type == 10 || *type == 11 || row.values.size() >= kMostColumns) return {};
    const std::uint64_t bytes = size_of(*type);
    if (bytes > payload->size() - body) return {};
    row.values.push_back(value_of(*type, std::span(*payload).subspan(body, bytes)));
    body += bytes;
  }
  return row;
}

}  // namespace tonus::store
