#include "services/recording/motion_rows.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <spdlog/fmt/fmt.h>

#include "services/recording/table.hpp"
#include "services/recording/text_file.hpp"

namespace tonus::recording {
namespace {

constexpr std::string_view kNothing = "n/a";

/// Walks over the text once; a number is parsed where it stands.
class RowParser {
 public:
  RowParser(const std::filesystem::path& file, std::string_view text, const std::vector<Column>& columns)
      : file_(file), place_(text.data()), end_(text.data() + text.size()), columns_(columns) {}

  [[nodiscard]] bool is_at_end() const { return place_ == end_; }

  Result<void> parse(Row& row, std::array<double, 2>& commanded) {
    ++line_;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const bool is_last = i + 1 == columns_.size();
      double value = 0.0;
      if (columns_[i] == Column::kIgnored) {
        place_ = cell_end();
      } else if (auto taken = take_number(i, value, row.is_missing); !taken) {
        return taken;
      }
      if (auto passed = pass_separator(is_last, i + 1); !passed) return passed;
      switch (columns_[i]) {
        case Column::kIgnored:
          break;
        case Column::kCount0:
          row.raw.encoder_count[0] = value;
          break;
        case Column::kCount1:
          row.raw.encoder_count[1] = value;
          break;
        case Column::kForce0:
          row.raw.force_V[0] = value;
          break;
        case Column::kForce1:
          row.raw.force_V[1] = value;
          break;
        case Column::kCommanded0:
          commanded[0] = value;
          break;
        case Column::kCommanded1:
          commanded[1] = value;
          break;
      }
    }
    return {};
  }

 private:
  [[nodiscard]] const char* cell_end() const {
    return std::find_if(place_, end_, [](char c) { return c == '\t' || c == '\n' || c == '\r'; });
  }

  [[nodiscard]] bool is_boundary(const char* place) const {
    return place == end_ || *place == '\t' || *place == '\n' || *place == '\r';
  }

  Result<void> take_number(std::size_t column, double& value, bool& is_missing) {
    const auto parsed = std::from_chars(place_, end_, value);
    if (parsed.ec == std::errc{} && is_boundary(parsed.ptr) && std::isfinite(value)) {
      place_ = parsed.ptr;
      return {};
    }
    const std::string_view cell(place_, static_cast<std::size_t>(cell_end() - place_));
    if (cell != kNothing) {
      return refuse_cell(file_, line_, std::to_string(column + 1), cell, "a number or n/a is needed");
    }
    value = 0.0;
    is_missing = true;
    place_ = cell_end();
    return {};
  }

  Result<void> pass_separator(bool is_last, std::size_t cells) {
    if (!is_last) {
      if (place_ != end_ && *place_ == '\t') return ++place_, Result<void>{};
      return refuse_count(cells);
    }
    if (place_ == end_) return {};
    if (*place_ == '\t') return refuse_count(cells + 1);
    if (*place_ == '\r') ++place_;
    if (place_ != end_ && *place_ == '\n') ++place_;
    return {};
  }

  [[nodiscard]] Error refuse_count(std::size_t cells) const {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("{}:{}: {}{} cells are not allowed: {} are needed, one for each line of _channels.tsv",
                    file_.string(), line_, cells, cells > columns_.size() ? " or more" : "",
                    columns_.size()));
  }

  const std::filesystem::path& file_;
  const char* place_;
  const char* end_;
  const std::vector<Column>& columns_;
  std::size_t line_ = 0;
};

}  // namespace

Result<void> read_rows(const std::filesystem::path& file, const std::vector<Column>& columns,
                       Recording& recording) {
  const auto text = read_text(file);
  if (!text) return text.error();
  const bool has_commanded = std::find(columns.begin(), columns.end(), Column::kCommanded0) != columns.end();
  RowParser parser(file, *text, columns);
  const auto lines = static_cast<std::size_t>(std::count(text->begin(), text->end(), '\n')) + 1;
  recording.rows.reserve(lines);
  if (has_commanded) recording.commanded.reserve(lines);
  while (!parser.is_at_end()) {
    Row row;
    std::array<double, 2> commanded{};
    if (auto parsed = parser.parse(row, commanded); !parsed) return parsed;
    if (row.is_missing) {
      row.raw = {};
      commanded = {};
    }
    row.raw.acquisition_ns = row_time_ns(recording, recording.rows.size());
    recording.rows.push_back(row);
    if (has_commanded) recording.commanded.push_back(commanded);
  }
  if (recording.rows.empty())
    return fail(ErrorCode::kInvalidArgument, file.string() + ": is empty: a row is needed");
  return {};
}

std::string rows_text(const Recording& recording, bool with_converted) {
  const std::vector<Channel> channels = channels_of(recording, with_converted);
  const bool is_one_axis = recording.rig.kind == RigKind::kOneAxis;
  constexpr std::size_t kTypicalCell = 12;
  std::string text;
  text.reserve(recording.rows.size() * channels.size() * kTypicalCell);
  std::vector<double> cells;
  for (std::size_t i = 0; i < recording.rows.size(); ++i) {
    const Row& row = recording.rows[i];
    const std::size_t axes = is_one_axis ? 1 : 2;
    cells.clear();
    for (std::size_t axis = 0; axis < axes; ++axis) cells.push_back(row.raw.encoder_count[axis]);
    for (std::size_t axis = 0; axis < axes; ++axis) cells.push_back(row.raw.force_V[axis]);
    if (recording.is_raw && !is_one_axis && with_converted) {
      const EndpointSample endpoint = convert(recording.rig, recording.shoulder, row.raw);
      cells.insert(cells.end(), {endpoint.p_SE[0], endpoint.p_SE[1], endpoint.f_S[0], endpoint.f_S[1]});
    }
    if (!recording.commanded.empty()) {
      for (std::size_t axis = 0; axis < axes; ++axis) cells.push_back(recording.commanded[i][axis]);
    }
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
      if (cell != 0) text.push_back('\t');
      if (row.is_missing) {
        text.append(kNothing);
      } else {
        append_number(text, cells[cell]);
      }
    }
    text.push_back('\n');
  }
  return text;
}

}  // namespace tonus::recording
