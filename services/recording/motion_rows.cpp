#include "services/recording/motion_rows.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <spdlog/fmt/fmt.h>

#include "services/recording/table.hpp"
#include "services/recording/text_file.hpp"

namespace tonus::recording {
namespace {

constexpr std::string_view kNothing = "n/a";
constexpr double kLastPhase = 7.0;  // as the contract numbers them

/// Walks over the text once; a number is parsed where it stands.
class RowParser {
 public:
  RowParser(const std::filesystem::path& file, std::string_view text, const std::vector<Column>& columns)
      : file_(file), place_(text.data()), end_(text.data() + text.size()), columns_(columns) {}

  [[nodiscard]] bool is_at_end() const { return place_ == end_; }

  Result<void> parse(Row& row, std::array<double, 2>& commanded, std::uint8_t& phase) {
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
        case Column::kPhase:
          if (!(value >= 0.0 && value <= kLastPhase && value == std::floor(value))) {
            return refuse_cell(file_, line_, std::to_string(i + 1), std::to_string(value),
                               "a whole number from 0 to 7 is needed");
          }
          phase = static_cast<std::uint8_t>(value);
          break;
      }
    }
    return {};
  }

 private:
  /// Steps over eight characters at a time where none of them is a control character: half of a file may be
  /// columns that are passed over.
  [[nodiscard]] const char* cell_end() const {
    constexpr std::uint64_t kEach = 0x0101010101010101U;
    const char* place = place_;
    for (std::uint64_t eight = 0; end_ - place >= 8; place += 8) {
      std::memcpy(&eight, place, sizeof eight);
      if (((eight - 0x20 * kEach) & ~eight & 0x80 * kEach) != 0) break;  // one of them is below 0x20
    }
    return std::find_if(place, end_, [](char c) { return c == '\t' || c == '\n' || c == '\r'; });
  }

  [[nodiscard]] bool is_boundary(const char* place) const {
    return place == end_ || *place == '\t' || *place == '\n' || *place == '\r';
  }

  /// Counts and zeros, which most cells are: up to eight digits with or without a sign, the same value as
  /// from_chars.
  bool take_short_whole_number(double& value) {
    constexpr std::ptrdiff_t kMostDigits = 8;
    const char* const first = place_ + (place_ != end_ && *place_ == '-' ? 1 : 0);
    const char* place = first;
    std::int32_t number = 0;
    for (; place != end_ && *place >= '0' && *place <= '9'; ++place) {
      if (place - first == kMostDigits) return false;
      number = 10 * number + (*place - '0');
    }
    if (place == first || !is_boundary(place)) return false;
    value = first == place_ ? number : -static_cast<double>(number);
    place_ = place;
    return true;
  }

  Result<void> take_number(std::size_t column, double& value, bool& is_missing) {
    if (take_short_whole_number(value)) return {};
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
  const bool has_phases = std::find(columns.begin(), columns.end(), Column::kPhase) != columns.end();
  RowParser parser(file, *text, columns);
  constexpr std::size_t kShortestLine = 16;  // a first line of n/a says little of the others
  const std::size_t lines = text->size() / std::max(text->find('\n') + 1, kShortestLine) + 1;
  recording.rows.reserve(lines);
  if (has_commanded) recording.commanded.reserve(lines);
  if (has_phases) recording.phases.reserve(lines);
  while (!parser.is_at_end()) {
    Row row;
    std::array<double, 2> commanded{};
    std::uint8_t phase = 0;
    if (auto parsed = parser.parse(row, commanded, phase); !parsed) return parsed;
    if (row.is_missing) {
      row.raw = {};
      commanded = {};
    }
    row.raw.acquisition_ns = row_time_ns(recording, recording.rows.size());
    recording.rows.push_back(row);
    if (has_commanded) recording.commanded.push_back(commanded);
    if (has_phases) recording.phases.push_back(phase);
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
    if (!recording.phases.empty()) cells.push_back(recording.phases[i]);
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
