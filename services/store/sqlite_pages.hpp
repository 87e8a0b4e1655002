#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "services/core/result.hpp"
#include "services/core/text_file.hpp"

namespace tonus::store {

/// A cell of a row: nothing, a whole number, a real number, text or bytes.
using SqliteValue = std::variant<std::monostate, std::int64_t, double, std::string, std::vector<std::byte>>;

struct SqliteRow {
  std::int64_t rowid = 0;
  std::vector<SqliteValue> values;
};

/// Where a row begins: enough to read it again.
struct SqliteCell {
  std::uint32_t page = 0;
  std::uint16_t offset = 0;
};

/// The pages of an SQLite file, healthy or not, with those of its write-ahead log over them: of each page the
/// newest version that a commit of the log made valid. Trusts nothing but the page size: rows are found by
/// looking at every page that says of itself that it is a leaf of a table, without the tree above it and
/// without the schema. Source: the SQLite file format, sections 1.3 to 1.6, 2.1 and 4.
class SqlitePages {
 public:
  /// The page size is the given one, else that of the header if it can be one, else 4096. kNotFound, kIo.
  [[nodiscard]] static Result<SqlitePages> open(const std::filesystem::path& path,
                                                std::optional<std::uint32_t> page_size = {});

  /// Visits every row of every table leaf, in the order of pages. A row that cannot be taken apart is left
  /// out.
  using Visitor = std::function<void(const SqliteRow& row, const SqliteCell& cell)>;
  [[nodiscard]] Result<void> visit_rows(
      const Visitor& visit, const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

  /// One row again.
  [[nodiscard]] std::optional<SqliteRow> read(const SqliteCell& cell);

  [[nodiscard]] std::uint32_t page_size() const { return page_size_; }
  [[nodiscard]] std::uint64_t pages() const { return pages_; }
  [[nodiscard]] std::uint64_t pages_in_header() const { return pages_in_header_; }
  [[nodiscard]] bool has_header() const { return has_header_; }
  [[nodiscard]] std::uint64_t pages_from_log() const { return log_.size(); }
  [[nodiscard]] std::uint64_t leaves() const { return leaves_; }  ///< Seen by the last visit.
  [[nodiscard]] std::uint64_t bad_cells() const {
    return bad_cells_;
  }  ///< Likewise: could not be taken apart.

 private:
  explicit SqlitePages(RegularFile file) : file_(std::move(file)) {}
  void read_log(const std::filesystem::path& path);
  [[nodiscard]] bool load(std::uint64_t number, std::vector<std::byte>& page) const;
  [[nodiscard]] std::optional<SqliteRow> parse(std::span<const std::byte> page, std::size_t offset) const;
  [[nodiscard]] std::optional<std::vector<std::byte>> payload_at(std::span<const std::byte> page,
                                                                 std::size_t offset,
                                                                 std::uint64_t size) const;

  RegularFile file_;
  std::uint32_t page_size_ = 4096;
  std::uint32_t usable_ = 4096;
  std::uint64_t pages_ = 0;
  std::uint64_t pages_in_header_ = 0;
  bool has_header_ = false;
  std::map<std::uint64_t, std::vector<std::byte>> log_;
  std::uint64_t leaves_ = 0;
  std::uint64_t bad_cells_ = 0;
};

}  // namespace tonus::store
