#pragma once

#include <concepts>
#include <span>
#include <string>
#include <string_view>

namespace tonus::formats {

/// Puts cells together to one line of a CSV file (RFC 4180, '\n').
class CsvLine {
 public:
  /// Quoted where it has to be, one line, and no formula for a spreadsheet: as_cell() of shown().
  void text(std::string_view given);
  /// The shortest text that reads back as the same double; nothing where it is not finite, which is not
  /// known.
  void number(double value);
  void whole(std::integral auto value) { plain(std::to_string(value)); }
  void nothing() { plain({}); }

  /// The line with its end; the next cell begins a new one.
  [[nodiscard]] std::string end();

 private:
  void plain(std::string_view cell);
  void separate();

  std::string line_;
  bool is_first_ = true;
};

/// A column of a table: what it is called and means, and how a row's cell comes about. `write` writes exactly
/// one cell.
template <typename Row>
struct CsvColumn {
  std::string_view name;
  std::string_view unit;
  std::string_view meaning;
  void (*write)(const Row& row, CsvLine& line);
};

template <typename Row>
[[nodiscard]] std::string header_of(std::span<const CsvColumn<Row>> columns) {
  CsvLine line;
  for (const auto& column : columns) line.text(column.name);
  return line.end();
}

template <typename Row>
[[nodiscard]] std::string line_of(std::span<const CsvColumn<Row>> columns, const Row& row) {
  CsvLine line;
  for (const auto& column : columns) column.write(row, line);
  return line.end();
}

/// One line a column: file, name, unit, meaning.
template <typename Row>
[[nodiscard]] std::string description_of(std::string_view file, std::span<const CsvColumn<Row>> columns) {
  std::string text;
  CsvLine line;
  for (const auto& column : columns) {
    for (const std::string_view cell : {file, column.name, column.unit, column.meaning}) line.text(cell);
    text += line.end();
  }
  return text;
}

}  // namespace tonus::formats
