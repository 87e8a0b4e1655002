#include "services/recording/auxiliary_files.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "services/core/json_text.hpp"
#include "services/core/text_file.hpp"
#include "services/recording/file_name.hpp"
#include "services/recording/json_file.hpp"
#include "services/recording/line_reader.hpp"
#include "services/recording/table.hpp"

namespace tonus::recording {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::string_view kLabel = "auxiliaryx";
constexpr std::string_view kMotion = "motion.tsv";
constexpr std::string_view kNothing = "n/a";
constexpr std::uint32_t kMostValues = static_cast<std::uint32_t>(kMostAuxiliaryValues);

fs::path beside(const fs::path& motion_file, std::string_view suffix) {
  std::string name = motion_file.string();
  name.replace(name.size() - kMotion.size(), std::string::npos, suffix);
  return name;
}

/// The series of one file, in the order of the recording's channels, and where each stands among those.
struct Group {
  std::vector<const AuxiliarySeries*> series;
  std::vector<std::size_t> places;
};

std::map<std::uint32_t, Group> groups_of(const Recording& recording) {
  std::map<std::uint32_t, Group> groups;
  for (std::size_t i = 0; i < recording.auxiliary.size(); ++i) {
    const AuxiliarySeries& series = recording.auxiliary[i];
    groups[series.values_per_sample].series.push_back(&series);
    groups[series.values_per_sample].places.push_back(i);
  }
  return groups;
}

void append_value(std::string& text, float value) {
  if (!std::isfinite(value)) {
    text.append(kNothing);
    return;
  }
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  text.append(digits.data(), end.ptr);
}

std::string values_text(const Group& group) {
  constexpr std::size_t kTypicalCell = 14;
  const std::size_t rows = group.series.front()->values.size();
  std::string text;
  text.reserve(rows * group.series.size() * kTypicalCell);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t i = 0; i < group.series.size(); ++i) {
      if (i != 0) text.push_back('\t');
      append_value(text, group.series[i]->values[row]);
    }
    text.push_back('\n');
  }
  return text;
}

std::string channels_table(const Group& group) {
  std::string text = "name\tcomponent\ttype\ttracked_point\tunits\tdescription\n";
  for (const AuxiliarySeries* series : group.series)
    text += fmt::format("{}\tn/a\tMISC\tn/a\t{}\t{}\n", series->channel.name, series->channel.unit,
                        series->channel.type);
  return text;
}

std::string channels_sidecar(const Group& group) {
  Json json;
  json["FirstValue_s"] = group.series.front()->time_of(0);
  for (std::size_t i = 0; i < group.series.size(); ++i)
    json["Auxiliary"][group.series[i]->channel.name] = {{"Type", group.series[i]->channel.type},
                                                        {"Place", group.places[i]}};
  return json_text(json, 2) + "\n";
}

std::string motion_sidecar(const Recording& recording, const Group& group,
                           const std::string& tracking_system) {
  const bool has_missing = std::ranges::any_of(group.series, [](const AuxiliarySeries* series) {
    return std::ranges::any_of(series->values, [](float value) { return !std::isfinite(value); });
  });
  Json json;
  json["TaskName"] = recording.task;
  json["SamplingFrequency"] = group.series.front()->channel.rate;
  json["TrackingSystemName"] = tracking_system;
  json["MISCChannelCount"] = group.series.size();
  json["MissingValues"] = has_missing ? "n/a" : "none";
  return json_text(json, 2) + "\n";
}

/// Walks over the rows of values.
class ValueParser {
 public:
  ValueParser(const AuxiliaryFile& file, std::vector<AuxiliarySeries*> columns)
      : file_(file), columns_(std::move(columns)) {}

  Result<void> take(std::string_view lines) {
    while (!lines.empty()) {
      const std::size_t end = std::min(lines.find('\n'), lines.size());
      std::string_view line = lines.substr(0, end);
      lines.remove_prefix(std::min(end + 1, lines.size()));
      if (line.ends_with('\r')) line.remove_suffix(1);
      ++line_;
      TONUS_TRY(take_line(line));
    }
    return {};
  }

 private:
  Result<void> take_line(std::string_view line) {
    for (std::size_t column = 0; column < columns_.size(); ++column) {
      const std::size_t end = std::min(line.find('\t'), line.size());
      const bool is_last = column + 1 == columns_.size();
      if ((end == line.size()) != is_last) return refuse_count();
      TONUS_TRY(take_cell(line.substr(0, end), column));
      line.remove_prefix(is_last ? end : end + 1);
    }
    return {};
  }

  Result<void> take_cell(std::string_view cell, std::size_t column) {
    float value = std::numeric_limits<float>::quiet_NaN();
    if (cell != kNothing) {
      const auto parsed = std::from_chars(cell.data(), cell.data() + cell.size(), value);
      if (parsed.ec != std::errc{} || parsed.ptr != cell.data() + cell.size() || !std::isfinite(value))
        return refuse_cell(file_.motion_file, line_, std::to_string(column + 1), cell, "a number or n/a");
    }
    columns_[column]->values.push_back(value);
    return {};
  }

  [[nodiscard]] Error refuse_count() const {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("{}:{}: this number of cells is not allowed; expected {}, one for each line of "
                            "_channels.tsv",
                            file_.motion_file.string(), line_, columns_.size()));
  }

  const AuxiliaryFile& file_;
  std::vector<AuxiliarySeries*> columns_;
  std::size_t line_ = 0;
};

Result<void> read_values(const AuxiliaryFile& file, std::vector<AuxiliarySeries*> columns, std::size_t rows) {
  TONUS_TRY_ASSIGN(auto reader, LineReader::open(file.motion_file));
  AuxiliarySeries* const first = columns.front();
  ValueParser parser(file, std::move(columns));
  while (true) {
    TONUS_TRY_ASSIGN(const auto lines, reader.next());
    if (lines.empty()) break;
    TONUS_TRY(parser.take(lines));
  }
  const std::size_t expected = rows * file.values_per_row;
  if (first->values.size() == expected) return {};
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("{}: {} rows are not allowed; expected {}, {} for each of the recording's",
                          file.motion_file.string(), first->values.size(), expected, file.values_per_row));
}

}  // namespace

std::uint32_t auxiliary_values_of(std::string_view tracking_system) {
  if (!tracking_system.starts_with(kLabel)) return 0;
  const std::string_view digits = tracking_system.substr(kLabel.size());
  std::uint32_t values = 0;
  const auto parsed = std::from_chars(digits.data(), digits.data() + digits.size(), values);
  const bool is_whole = parsed.ec == std::errc{} && parsed.ptr == digits.data() + digits.size();
  return is_whole && values >= 1 && values <= kMostValues ? values : 0;
}

Result<AuxiliaryFile> open_auxiliary(const fs::path& motion_file, std::uint32_t values_per_row, double rate) {
  AuxiliaryFile file{motion_file, values_per_row, {}, {}};
  TONUS_TRY_ASSIGN(const auto motion, JsonFile::read(beside(motion_file, "motion.json")));
  TONUS_TRY_ASSIGN(const auto stated, motion.number("SamplingFrequency"));
  const double expected = rate * values_per_row;
  constexpr double kTolerance = 1e-6;
  if (!(std::abs(stated - expected) <= kTolerance * expected)) {
    return motion.refuse("SamplingFrequency", fmt::format("{} Hz, {} values for each row of the recording",
                                                          expected, values_per_row));
  }
  TONUS_TRY_ASSIGN(const auto table, Table::read(beside(motion_file, "channels.tsv")));
  TONUS_TRY(table.require({"name", "units"}));
  TONUS_TRY_ASSIGN(const auto json, JsonFile::read(beside(motion_file, "channels.json")));
  for (std::size_t row = 0; row < table.rows(); ++row) {
    AuxiliaryChannel channel;
    channel.name = std::string(table.cell(row, "name"));
    if (const auto fault = fault_of_auxiliary_name(channel.name); !fault.empty())
      return table.refuse(row, "name", "letters and digits");
    const std::string key = "Auxiliary." + channel.name;
    TONUS_TRY_ASSIGN(channel.type, json.text(key + ".Type", "MISC"));
    channel.unit = std::string(table.cell(row, "units"));
    channel.rate = expected;
    TONUS_TRY_ASSIGN(const auto place, json.number(key + ".Place", static_cast<double>(row)));
    if (!(place >= 0.0 && place < static_cast<double>(kMostAuxiliaryChannels)))
      return json.refuse(key + ".Place", fmt::format("0 to {}", kMostAuxiliaryChannels - 1));
    file.channels.push_back(std::move(channel));
    file.places.push_back(static_cast<std::size_t>(place));
  }
  if (const auto good = validate(file.channels, rate); !good)
    return fail(good.error().code, motion_file.string() + ": " + good.error().message);
  if (file.channels.empty())
    return fail(ErrorCode::kInvalidArgument, motion_file.string() + ": has no channel; expected one");
  return file;
}

Result<void> read_auxiliary(const std::vector<AuxiliaryFile>& files, Recording& recording) {
  struct Column {
    std::size_t place = 0;
    const AuxiliaryFile* file = nullptr;
    const AuxiliaryChannel* channel = nullptr;
  };
  std::vector<Column> columns;
  std::vector<AuxiliaryChannel> channels;
  for (const AuxiliaryFile& file : files)
    for (std::size_t i = 0; i < file.channels.size(); ++i)
      columns.push_back({file.places[i], &file, &file.channels[i]});
  std::ranges::stable_sort(columns, {}, &Column::place);
  for (const Column& column : columns) {
    channels.push_back(*column.channel);
    recording.auxiliary.push_back({*column.channel, column.file->values_per_row, {}});
  }
  if (const auto good = validate(channels, recording.sampling_frequency); !good)
    return fail(good.error().code, describe(recording) + ": " + good.error().message);
  for (const AuxiliaryFile& file : files) {
    std::vector<AuxiliarySeries*> series;
    for (const AuxiliaryChannel& channel : file.channels)
      series.push_back(&*std::ranges::find(recording.auxiliary, channel.name,
                                           [](const AuxiliarySeries& s) { return s.channel.name; }));
    for (AuxiliarySeries* each : series) each->values.reserve(recording.rows.size() * file.values_per_row);
    TONUS_TRY(read_values(file, std::move(series), recording.rows.size()));
  }
  return {};
}

Result<void> write_auxiliary(const fs::path& folder, const Recording& recording) {
  for (const auto& [values, group] : groups_of(recording)) {
    Recording named;  // its labels, of that tracking system
    named.participant.id = recording.participant.id;
    named.session = recording.session;
    named.task = recording.task;
    named.acquisition = recording.acquisition;
    named.run = recording.run;
    named.tracking_system = fmt::format("{}{}", kLabel, values);
    TONUS_TRY_ASSIGN(const auto name, run_stem(named));
    const std::string stem = (folder / name).string();
    TONUS_TRY(create_text_file(stem + "_motion.tsv", values_text(group)));
    TONUS_TRY(
        create_text_file(stem + "_motion.json", motion_sidecar(recording, group, named.tracking_system)));
    TONUS_TRY(create_text_file(stem + "_channels.tsv", channels_table(group)));
    TONUS_TRY(create_text_file(stem + "_channels.json", channels_sidecar(group)));
  }
  return {};
}

Result<void> check_auxiliary(const Recording& recording) {
  std::vector<AuxiliaryChannel> channels;
  for (const AuxiliarySeries& series : recording.auxiliary) channels.push_back(series.channel);
  TONUS_TRY(validate(channels, recording.sampling_frequency));
  for (const AuxiliarySeries& series : recording.auxiliary) {
    const std::size_t expected = recording.rows.size() * series.values_per_sample;
    if (series.values.size() == expected) continue;
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("channel {}: {} values are not allowed; expected {}, {} for each row",
                            series.channel.name, series.values.size(), expected, series.values_per_sample));
  }
  return {};
}

}  // namespace tonus::recording
