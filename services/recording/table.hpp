#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/result.hpp"

namespace tonus::recording {

/// "file:line: column 'name': 'value' is not allowed: allowed."
[[nodiscard]] Error refuse_cell(const std::filesystem::path& file, std::size_t line, std::string_view column,
                                std::string_view value, std::string_view allowed);

/// A finite decimal number that fills the cell, not depending on the locale.
[[nodiscard]] std::optional<double> parse_number(std::string_view cell);

/// A tab-separated file with a header, in memory. Rows count from 0 and exclude the header.
class Table {
 public:
  /// kInvalidArgument: no header, a column named twice, or a row with another number of cells than the
  /// header.
  [[nodiscard]] static Result<Table> read(const std::filesystem::path& file);

  [[nodiscard]] std::size_t rows() const { return rows_.size(); }
  [[nodiscard]] bool has(std::string_view column) const { return find(column).has_value(); }
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }

  /// kInvalidArgument for the first of `needed` that is not a column.
  [[nodiscard]] Result<void> require(const std::vector<std::string_view>& needed) const;

  /// The cell; "n/a" where the table has no such column.
  [[nodiscard]] std::string_view cell(std::size_t row, std::string_view column) const;

  /// The cell, empty where it is n/a.
  [[nodiscard]] std::string text(std::size_t row, std::string_view column) const;

  /// A number, or nothing where the cell is n/a.
  [[nodiscard]] Result<std::optional<double>> number_or_nothing(std::size_t row,
                                                                std::string_view column) const;

  /// A number of at least `minimum`; `fallback` where the cell is n/a, an error if there is none.
  [[nodiscard]] Result<double> number(std::size_t row, std::string_view column, double minimum,
                                      std::optional<double> fallback = {}) const;

  /// A whole number, 1 as well as 1.0; `fallback` where the cell is n/a.
  [[nodiscard]] Result<std::int64_t> whole_number(std::size_t row, std::string_view column,
                                                  std::int64_t fallback) const;

  [[nodiscard]] Error refuse(std::size_t row, std::string_view column, std::string_view allowed) const;

 private:
  [[nodiscard]] std::optional<std::size_t> find(std::string_view column) const;

  std::filesystem::path file_;
  std::vector<std::string> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace tonus::recording
