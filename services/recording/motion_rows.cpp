#include "services/recording/motion_rows.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <spdlog/fmt/fmt.h>

#include "services/recording/line_reader.hpp"
#include "services/recording/number_text.hpp"
#include "services/recording/table.hpp"

namespace tonus::recording {
namespace {

constexpr std::string_view kNothing = "n/a";
constexpr double kLastPhase = 7.0;  // as the contract numbers them
constexpr std::size_t kColumns = static_cast<std::size_t>(Column::kPhase) + 1;

/// Walks over the text once; a number is parsed where it stands. A method that returns false has stated the
/// error.
class RowParser {
 public:
  RowParser(const std::filesystem::path& file, const Columns& columns, const std::string& missing_value)
      : file_(file),
        columns_(columns),
        missing_(missing_value),
        missing_number_(parse_number(missing_value)) {}

  /// The lines to parse next. All before have been parsed.
  void take(std::string_view lines) {
    place_ = lines.data();
    end_ = lines.data() + lines.size();
  }

  [[nodiscard]] bool is_at_end() const { return place_ == end_; }

  /// The next row; it is missing where a measured cell of it is.
  [[nodiscard]] bool parse() {
    ++line_;
    is_missing_ = false;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i].what == Column::kIgnored) {
        place_ = cell_end();
      } else if (!take_number(i, values_[static_cast<std::size_t>(columns_[i].what)])) {
        return false;
      }
      if (!pass_separator(i + 1)) return false;
    }
    const double phase = value(Column::kPhase);
    return (phase >= 0.0 && phase <= kLastPhase && phase == std::floor(phase)) || refuse_phase();
  }

  [[nodiscard]] bool is_missing() const { return is_missing_; }
  /// Of the row; zero where no column holds it.
  [[nodiscard]] double value(Column column) const { return values_[static_cast<std::size_t>(column)]; }
  [[nodiscard]] const Error& error() const { return *error_; }

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

  bool take_number(std::size_t column, double& value) {
    const char* const begin = place_;
    bool is_number = take_short_whole_number(value);
    if (!is_number) {
      const auto parsed = std::from_chars(place_, end_, value);
      is_number = parsed.ec == std::errc{} && is_boundary(parsed.ptr) && std::isfinite(value);
      if (is_number) place_ = parsed.ptr;
    }
    if (is_number && (!missing_number_ || value != *missing_number_)) {
      value *= columns_[column].scale;  // 1 leaves every bit as it is
      return true;
    }
    place_ = begin;
    const std::string_view cell(place_, static_cast<std::size_t>(cell_end() - place_));
    if (!is_number && cell != kNothing && (missing_.empty() || cell != missing_)) {
      error_ = refuse_cell(file_, line_, std::to_string(column + 1), cell, "a number or n/a");
      return false;
    }
    const Column what = columns_[column].what;
    const bool is_optional =
        what == Column::kCommanded0 || what == Column::kCommanded1 || what == Column::kLatency;
    value = is_optional ? std::numeric_limits<double>::quiet_NaN() : 0.0;
    // A command that is not known takes nothing from what was measured.
    is_missing_ = is_missing_ || !is_optional;
    place_ = cell_end();
    return true;
  }

  /// Behind the `cells`th cell of the row.
  bool pass_separator(std::size_t cells) {
    if (cells < columns_.size()) {
      if (place_ == end_ || *place_ != '\t') return refuse_count(cells);
      ++place_;
      return true;
    }
    if (place_ == end_) return true;
    if (*place_ == '\t') return refuse_count(cells + 1);
    if (*place_ == '\r') ++place_;
    if (place_ != end_ && *place_ == '\n') ++place_;
    return true;
  }

  bool refuse_count(std::size_t cells) {
    error_ =
        fail(ErrorCode::kInvalidArgument,
             fmt::format("{}:{}: {}{} cells are not allowed; expected {}, one for each line of _channels.tsv",
                         file_.string(), line_, cells, cells > columns_.size() ? " or more" : "",
                         columns_.size()));
    return false;
  }

  bool refuse_phase() {
    const auto column = std::ranges::find(columns_, Column::kPhase, &ColumnUse::what) - columns_.begin();
    error_ = refuse_cell(file_, line_, std::to_string(column + 1), std::to_string(value(Column::kPhase)),
                         "a whole number from 0 to 7");
    return false;
  }

  const std::filesystem::path& file_;
  const Columns& columns_;
  const std::string& missing_;
  std::optional<double> missing_number_;
  const char* place_ = nullptr;
  const char* end_ = nullptr;
  std::size_t line_ = 0;
  std::array<double, kColumns> values_{};
  bool is_missing_ = false;
  std::optional<Error> error_;
};

/// Time stamps of the rows against the rate that the recording states.
class Stamps {
 public:
  explicit Stamps(double rate) : rate_(rate) {}

  void add(std::size_t row, double time) {
    if (!std::isfinite(time)) return;
    if (!has_first_) first_ = {row, time};
    has_first_ = true;
    last_ = {row, time};
    const double off = time - first_.time - static_cast<double>(row - first_.row) / rate_;
    if (is_irregular_ || !(std::abs(off) > 0.5 / rate_)) return;
    is_irregular_ = true;
    wrong_ = {row, time};
  }

  [[nodiscard]] Result<void> check(const std::filesystem::path& file) const {
    constexpr double kTolerance = 1e-3;  // of the rate
    if (!has_first_ || last_.row == first_.row) return {};
    const double rate = static_cast<double>(last_.row - first_.row) / (last_.time - first_.time);
    if (!(std::abs(rate - rate_) <= kTolerance * rate_)) {
      return fail(
          ErrorCode::kInvalidArgument,
          fmt::format("{}: time stamps of {:.6g} Hz are not allowed; expected {:.6g} Hz, as _motion.json "
                      "states",
                      file.string(), rate, rate_));
    }
    if (!is_irregular_) return {};
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("{}:{}: a time stamp {:.6g} s after the first is not allowed; expected {:.6g} s, as rows "
                    "are equally spaced",
                    file.string(), wrong_.row + 1, wrong_.time - first_.time,
                    static_cast<double>(wrong_.row - first_.row) / rate_));
  }

 private:
  struct Stamp {
    std::size_t row = 0;
    double time = 0.0;
  };
  double rate_;
  bool has_first_ = false;
  bool is_irregular_ = false;
  Stamp first_;
  Stamp wrong_;  // the first one that is irregular
  Stamp last_;
};

}  // namespace

Result<void> read_rows(const std::filesystem::path& file, const Columns& columns,
                       const std::string& missing_value, Recording& recording) {
  TONUS_TRY_ASSIGN(auto reader, LineReader::open(file));
  const auto has = [&](Column what) {
    return std::ranges::find(columns, what, &ColumnUse::what) != columns.end();
  };
  const bool has_commanded = has(Column::kCommanded0);
  const bool has_phases = has(Column::kPhase);
  const bool has_stamps = has(Column::kLatency);
  RowParser parser(file, columns, missing_value);
  Stamps stamps(recording.sampling_frequency);
  while (true) {
    TONUS_TRY_ASSIGN(const auto lines, reader.next());
    if (lines.empty()) break;
    if (recording.rows.empty()) {
      constexpr std::size_t kShortestLine = 16;  // a first line of n/a says little of the others
      constexpr std::size_t kMostReserved = std::size_t{1} << 22U;  // a file's size may be a hole
      const std::size_t rows =
          std::min(reader.size() / std::max(lines.find('\n') + 1, kShortestLine) + 1, kMostReserved);
      recording.rows.reserve(rows);
      if (has_commanded) recording.commanded.reserve(rows);
      if (has_phases) recording.phases.reserve(rows);
    }
    parser.take(lines);
    while (!parser.is_at_end()) {
      if (!parser.parse()) return parser.error();
      Row& row = recording.rows.emplace_back();
      row.is_missing = parser.is_missing();
      row.raw.acquisition_ns = row_time_ns(recording, recording.rows.size() - 1);
      if (!row.is_missing) {
        row.raw.encoder_count = {parser.value(Column::kCount0), parser.value(Column::kCount1)};
        row.raw.force_V = {parser.value(Column::kForce0), parser.value(Column::kForce1)};
      }
      if (has_commanded) {
        const std::array commanded{parser.value(Column::kCommanded0), parser.value(Column::kCommanded1)};
        recording.commanded.push_back(row.is_missing ? kNoCommand : commanded);
      }
      if (has_stamps) stamps.add(recording.rows.size() - 1, parser.value(Column::kLatency));
      if (has_phases) recording.phases.push_back(static_cast<std::uint8_t>(parser.value(Column::kPhase)));
    }
  }
  if (recording.rows.empty())
    return fail(ErrorCode::kInvalidArgument, file.string() + ": is empty; expected a row");
  return stamps.check(file);
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
      if (row.is_missing || !std::isfinite(cells[cell])) {
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
