#include "services/recording/table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <spdlog/fmt/fmt.h>

#include "services/core/text.hpp"
#include "services/recording/line_reader.hpp"

namespace tonus::recording {
namespace {

constexpr std::string_view kNothing = "n/a";

std::vector<std::string> split_cells(std::string_view line) {
  std::vector<std::string> cells;
  while (true) {
    const std::size_t tab = line.find('\t');
    cells.emplace_back(line.substr(0, tab));
    if (tab == std::string_view::npos) return cells;
    line.remove_prefix(tab + 1);
  }
}

}  // namespace

Error refuse_cell(const std::filesystem::path& file, std::size_t line, std::string_view column,
                  std::string_view value, std::string_view allowed) {
  constexpr std::size_t kLongest = 40;
  const std::string quoted = shown(value.substr(0, kLongest)) + (value.size() > kLongest ? "..." : "");
  return fail(ErrorCode::kInvalidArgument, fmt::format("{}:{}: column '{}': '{}' is not allowed; expected {}",
                                                       file.string(), line, column, quoted, allowed));
}

std::optional<double> parse_number(std::string_view cell) {
  double value = 0.0;
  const auto parsed = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (parsed.ec != std::errc{} || parsed.ptr != cell.data() + cell.size() || !std::isfinite(value)) return {};
  return value;
}

Result<Table> Table::read(const std::filesystem::path& file) {
  TONUS_TRY_ASSIGN(auto text, read_unmarked(file));
  Table table;
  table.file_ = file;
  std::string_view rest = text;
  for (std::size_t line_number = 1; !rest.empty(); ++line_number) {
    const std::size_t end = rest.find('\n');
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.empty() && rest.empty()) break;
    if (!is_utf8(line)) {
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("{}:{}: '{}' is not UTF-8 text; expected the file in UTF-8, as BIDS has it",
                              file.string(), line_number, shown(line.substr(0, 40))));
    }
    std::vector<std::string> cells = split_cells(line);
    if (line_number == 1) {
      table.columns_ = std::move(cells);
      continue;
    }
    if (cells.size() != table.columns_.size()) {
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("{}:{}: {} cells are not allowed: the header has {}", file.string(),
                              line_number, cells.size(), table.columns_.size()));
    }
    table.rows_.push_back(std::move(cells));
  }
  if (table.columns_.empty()) {
    return fail(ErrorCode::kInvalidArgument, file.string() + ": is empty; expected a header line");
  }
  for (auto column = table.columns_.begin(); column != table.columns_.end(); ++column) {
    if (std::find(table.columns_.begin(), column, *column) != column) {
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("{}:1: column '{}' occurs twice; expected once", file.string(), *column));
    }
  }
  return table;
}

Result<void> Table::require(const std::vector<std::string_view>& needed) const {
  for (const std::string_view column : needed) {
    if (has(column)) continue;
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("{}:1: column '{}' is missing; expected the columns {}", file_.string(), column,
                            fmt::join(needed, ", ")));
  }
  return {};
}

std::optional<std::size_t> Table::find(std::string_view column) const {
  const auto place = std::find(columns_.begin(), columns_.end(), column);
  if (place == columns_.end()) return {};
  return static_cast<std::size_t>(place - columns_.begin());
}

std::string_view Table::cell(std::size_t row, std::string_view column) const {
  const auto place = find(column);
  return place ? std::string_view(rows_[row][*place]) : kNothing;
}

std::string Table::text(std::size_t row, std::string_view column) const {
  const std::string_view value = cell(row, column);
  return value == kNothing ? std::string() : shown(value);
}

Result<std::optional<double>> Table::number_or_nothing(std::size_t row, std::string_view column) const {
  const std::string_view value = cell(row, column);
  if (value == kNothing) return std::optional<double>();
  const auto number = parse_number(value);
  if (!number) return refuse(row, column, "a number or n/a");
  return number;
}

Result<double> Table::number(std::size_t row, std::string_view column, double minimum,
                             std::optional<double> fallback) const {
  if (fallback && cell(row, column) == kNothing) return *fallback;
  const auto number = parse_number(cell(row, column));
  if (!number || *number < minimum)
    return refuse(row, column, fmt::format("a number of at least {}", minimum));
  return *number;
}

Result<std::int64_t> Table::whole_number(std::size_t row, std::string_view column,
                                         std::int64_t fallback) const {
  constexpr std::int64_t kMost = 1'000'000'000;  // there is room to count on from it
  const std::string_view value = cell(row, column);
  if (value == kNothing) return fallback;
  const auto number = parse_number(value);
  if (!number || *number != std::floor(*number) || std::abs(*number) > static_cast<double>(kMost))
    return refuse(row, column, fmt::format("a whole number from {} to {}", -kMost, kMost));
  return static_cast<std::int64_t>(*number);
}

Error Table::refuse(std::size_t row, std::string_view column, std::string_view allowed) const {
  return refuse_cell(file_, row + 2, column, cell(row, column), allowed);
}

}  // namespace tonus::recording
