#include "services/recording/events.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "services/core/json_text.hpp"
#include "services/core/text.hpp"
#include "services/recording/number_text.hpp"

namespace tonus::recording {
namespace {

double record_duration_s(const Recording& recording) {
  return static_cast<double>(recording.rows.size()) / recording.sampling_frequency;
}

/// The whole trial, where it is stated, lies within the record and holds the onset, to half a sample.
Result<void> check_trial(const Table& table, std::size_t row, const std::optional<double>& trial_onset,
                         const std::optional<double>& trial_duration, double onset,
                         const Recording& recording) {
  if (!trial_onset && !trial_duration) return {};
  if (!trial_onset || !trial_duration)
    return table.refuse(row, trial_onset ? "trial_duration_s" : "trial_onset_s", "both or none");
  const double half_sample = 0.5 / recording.sampling_frequency;
  const double end = *trial_onset + *trial_duration;
  if (*trial_onset >= 0.0 && *trial_duration > 0.0 && end <= record_duration_s(recording) + half_sample &&
      *trial_onset <= onset + half_sample && onset <= end + half_sample) {
    return {};
  }
  return table.refuse(row, "trial_onset_s",
                      fmt::format("a trial that holds the onset {} s and lies within the record's {} s",
                                  onset, record_duration_s(recording)));
}

/// True where the cell is n/a. Programs write a truth as True, TRUE, 1 and 1.0, too.
Result<bool> read_valid(const Table& table, std::size_t row) {
  std::string cell(table.cell(row, "valid"));
  std::ranges::transform(cell, cell.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  const auto number = parse_number(cell);
  if (cell == "true" || cell == "n/a" || number == 1.0) return true;
  if (cell == "false" || number == 0.0) return false;
  return table.refuse(row, "valid", "true, false or n/a");
}

/// The event of a row, but for its trial's number.
Result<PerturbationEvent> read_event(const Table& table, std::size_t row, const Recording& recording) {
  PerturbationEvent event;
  const auto onset = table.number(row, "onset", 0.0);
  if (!onset) return onset.error();
  const auto duration = table.number(row, "duration", 0.0);
  if (!duration) return duration.error();
  const double half_sample = 0.5 / recording.sampling_frequency;
  if (*onset + *duration > record_duration_s(recording) + half_sample) {
    return table.refuse(row, "duration",
                        fmt::format("an end within the record's {1} s, from the onset at {0} s", *onset,
                                    record_duration_s(recording)));
  }
  TONUS_TRY_ASSIGN(const auto set, table.whole_number(row, "set", 1));
  TONUS_TRY_ASSIGN(const auto direction, table.number_or_nothing(row, "direction_deg"));
  TONUS_TRY_ASSIGN(const auto amplitude, table.number_or_nothing(row, "amplitude_m"));
  TONUS_TRY_ASSIGN(const auto rise_time, table.number_or_nothing(row, "rise_time_s"));
  TONUS_TRY_ASSIGN(const auto bias_x, table.number_or_nothing(row, "bias_x_N"));
  TONUS_TRY_ASSIGN(const auto bias_y, table.number_or_nothing(row, "bias_y_N"));
  TONUS_TRY_ASSIGN(const auto bias_hold, table.number_or_nothing(row, "bias_hold_s"));
  TONUS_TRY_ASSIGN(const auto bias_threshold, table.number_or_nothing(row, "bias_threshold_N"));
  TONUS_TRY_ASSIGN(const auto trial_onset, table.number_or_nothing(row, "trial_onset_s"));
  TONUS_TRY_ASSIGN(const auto trial_duration, table.number_or_nothing(row, "trial_duration_s"));
  TONUS_TRY(check_trial(table, row, trial_onset, trial_duration, *onset, recording));
  TONUS_TRY_ASSIGN(const bool is_valid, read_valid(table, row));
  event.onset_s = *onset;
  event.duration_s = *duration;
  event.set = set;
  event.direction_deg = direction;
  event.amplitude_m = amplitude;
  event.rise_time_s = rise_time;
  event.bias_N = {bias_x.value_or(0.0), bias_y.value_or(0.0)};
  event.is_valid = is_valid;
  event.reason = table.text(row, "reason");
  event.instruction = table.text(row, "instruction");
  event.bias_hold_s = bias_hold;
  event.bias_threshold_N = bias_threshold;
  event.trial_onset_s = trial_onset;
  event.trial_duration_s = trial_duration;
  return event;
}

void append_optional(std::string& text, const std::optional<double>& value) {
  text += '\t';
  if (value) {
    append_number(text, *value);
  } else {
    text += "n/a";
  }
}

/// A reason in one cell: no tabs or line ends.
std::string one_cell(std::string text) {
  if (text.empty()) return "n/a";
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\t' || c == '\n' || c == '\r'; }, ' ');
  return shown(text);
}

}  // namespace

Result<EventTable> EventTable::read(const std::filesystem::path& file) {
  TONUS_TRY_ASSIGN(auto table, Table::read(file));
  EventTable events(std::move(table));
  const Table& cells = events.table_;
  TONUS_TRY(cells.require({"onset", "duration"}));
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    if (cells.has("trial_type") && cells.cell(row, "trial_type") != "perturbation") continue;
    std::optional<std::int64_t> trial;
    if (cells.cell(row, "trial") != "n/a") {
      TONUS_TRY_ASSIGN(trial, cells.whole_number(row, "trial", 0));
    }
    events.rows_.push_back(row);
    events.trials_.push_back(trial);
  }
  if (events.rows_.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                file.string() + ": has no row of trial_type perturbation; expected one");
  }
  return events;
}

Result<std::vector<PerturbationEvent>> EventTable::events(const Recording& recording,
                                                          Imperfect imperfect) const {
  std::vector<PerturbationEvent> events;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    auto event = read_event(table_, rows_[i], recording);
    if (!event && imperfect == Imperfect::kRefused) return event.error();
    if (!event) {
      PerturbationEvent left_out;
      if (const auto direction = table_.number_or_nothing(rows_[i], "direction_deg"))
        left_out.direction_deg = *direction;
      if (const auto set = table_.whole_number(rows_[i], "set", 1)) left_out.set = *set;
      left_out.is_valid = false;
      left_out.reason = event.error().message;
      event = left_out;
    }
    event->trial = trials_[i].value_or(static_cast<std::int64_t>(i) + 1);
    events.push_back(*std::move(event));
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const auto& a, const auto& b) { return a.onset_s < b.onset_s; });
  return events;
}

PerturbationEvent whole_record(const Recording& recording, std::int64_t trial) {
  PerturbationEvent event;
  event.duration_s = record_duration_s(recording);
  event.trial = trial;
  return event;
}

namespace {

constexpr const char* kColumns =
    "onset\tduration\ttrial_type\ttrial\tset\tdirection_deg\tamplitude_m\trise_time_s\tbias_x_N\tbias_y_N\t"
    "valid\treason\tinstruction\tbias_hold_s\tbias_threshold_N\ttrial_onset_s\ttrial_duration_s";

void append_event(std::string& text, const PerturbationEvent& event) {
  append_number(text, event.onset_s);
  text += '\t';
  append_number(text, event.duration_s);
  text += fmt::format("\tperturbation\t{}\t{}", event.trial, event.set);
  append_optional(text, event.direction_deg);
  append_optional(text, event.amplitude_m);
  append_optional(text, event.rise_time_s);
  append_optional(text, event.bias_N[0]);
  append_optional(text, event.bias_N[1]);
  text += event.is_valid ? "\ttrue\t" : "\tfalse\t";
  text += one_cell(event.reason) + '\t' + one_cell(event.instruction);
  append_optional(text, event.bias_hold_s);
  append_optional(text, event.bias_threshold_N);
  append_optional(text, event.trial_onset_s);
  append_optional(text, event.trial_duration_s);
}

void append_note(std::string& text, const NoteEvent& note) {
  constexpr int kCellsOfPerturbations = 13;  // set to trial_duration_s
  append_number(text, note.onset_s);
  text += "\t0\t" + note.kind + '\t' + (note.trial ? std::to_string(*note.trial) : "n/a");
  for (int i = 0; i < kCellsOfPerturbations; ++i) text += "\tn/a";
  text += '\t' + one_cell(note.text) + '\t' + one_cell(note.written_by) + '\n';
}

}  // namespace

std::string events_text(const std::vector<PerturbationEvent>& events, const std::vector<NoteEvent>& notes) {
  std::string text = std::string(kColumns) + (notes.empty() ? "\n" : "\tnote\tnoted_by\n");
  auto note = notes.begin();
  for (const PerturbationEvent& event : events) {
    for (; note != notes.end() && note->onset_s < event.onset_s; ++note) append_note(text, *note);
    append_event(text, event);
    text += notes.empty() ? "\n" : "\tn/a\tn/a\n";
  }
  for (; note != notes.end(); ++note) append_note(text, *note);
  return text;
}

std::string events_json(bool has_notes) {
  nlohmann::ordered_json json;
  const auto describe_column = [&json](const char* column, const char* description, const char* units) {
    json[column]["Description"] = description;
    if (*units != '\0') json[column]["Units"] = units;
  };
  describe_column("trial", "Number of the trial, unique in the session", "");
  describe_column("set", "Number of the set that the trial belongs to", "");
  describe_column("direction_deg",
                  "Direction of the perturbation in the shoulder frame, counter-clockwise from its x axis; "
                  "n/a: continuous",
                  "deg");
  describe_column("amplitude_m", "Amplitude of the commanded displacement", "m");
  describe_column("rise_time_s", "Rise time of the commanded displacement", "s");
  describe_column("bias_x_N", "Bias force on the arm, x in the shoulder frame", "N");
  describe_column("bias_y_N", "Bias force on the arm, y in the shoulder frame", "N");
  describe_column("valid", "Whether the trial counts", "");
  json["valid"]["Levels"] = {{"true", "it counts"}, {"false", "it does not; the reason column says why"}};
  describe_column("reason", "Why the trial does not count", "");
  describe_column("instruction", "What the subject was told; n/a: hold still", "");
  describe_column("bias_hold_s", "Time from reaching the bias force to the onset", "s");
  describe_column("bias_threshold_N", "Allowed deviation from the bias force", "N");
  describe_column("trial_onset_s",
                  "Begin of the whole trial, centring and waiting included, from the first sample", "s");
  describe_column("trial_duration_s", "Duration of the whole trial, the way back included", "s");
  if (has_notes) {
    json["trial_type"]["Levels"] = {
        {"perturbation", "the hand was moved"},
        {"note", "an operator wrote a note, about the trial of that number if it has one"},
        {"marker", "an operator set a marker"}};
    describe_column("note", "What the operator wrote", "");
    describe_column("noted_by", "Who wrote it", "");
  }
  return json_text(json, 2) + "\n";
}

}  // namespace tonus::recording
