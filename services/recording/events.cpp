#include "services/recording/events.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "services/core/json_text.hpp"
#include "services/core/text.hpp"
#include "services/recording/number_text.hpp"

namespace tonus::recording {
namespace {

// Words of the column trial_type.
constexpr const char* kPerturbation = "perturbation";
constexpr const char* kContraction = "reference_contraction";

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

/// What a perturbation and a reference contraction both have in a row, but for the trial's number.
Result<PerturbationEvent> read_common(const Table& table, std::size_t row, const Recording& recording) {
  PerturbationEvent event;
  TONUS_TRY_ASSIGN(event.onset_s, table.number(row, "onset", 0.0));
  TONUS_TRY_ASSIGN(event.duration_s, table.number(row, "duration", 0.0));
  const double half_sample = 0.5 / recording.sampling_frequency;
  if (event.onset_s + event.duration_s > record_duration_s(recording) + half_sample) {
    return table.refuse(row, "duration",
                        fmt::format("an end within the record's {1} s, from the onset at {0} s",
                                    event.onset_s, record_duration_s(recording)));
  }
  TONUS_TRY_ASSIGN(event.trial_onset_s, table.number_or_nothing(row, "trial_onset_s"));
  TONUS_TRY_ASSIGN(event.trial_duration_s, table.number_or_nothing(row, "trial_duration_s"));
  TONUS_TRY(check_trial(table, row, event.trial_onset_s, event.trial_duration_s, event.onset_s, recording));
  TONUS_TRY_ASSIGN(event.is_valid, read_valid(table, row));
  event.reason = table.text(row, "reason");
  event.instruction = table.text(row, "instruction");
  return event;
}

/// The perturbation of a row, but for its trial's number.
Result<PerturbationEvent> read_perturbation(const Table& table, std::size_t row, const Recording& recording) {
  TONUS_TRY_ASSIGN(PerturbationEvent event, read_common(table, row, recording));
  TONUS_TRY_ASSIGN(event.set, table.whole_number(row, "set", 1));
  TONUS_TRY_ASSIGN(event.direction_deg, table.number_or_nothing(row, "direction_deg"));
  TONUS_TRY_ASSIGN(event.amplitude_m, table.number_or_nothing(row, "amplitude_m"));
  TONUS_TRY_ASSIGN(event.rise_time_s, table.number_or_nothing(row, "rise_time_s"));
  TONUS_TRY_ASSIGN(const auto bias_x, table.number_or_nothing(row, "bias_x_N"));
  TONUS_TRY_ASSIGN(const auto bias_y, table.number_or_nothing(row, "bias_y_N"));
  event.bias_N = {bias_x.value_or(0.0), bias_y.value_or(0.0)};
  TONUS_TRY_ASSIGN(event.bias_hold_s, table.number_or_nothing(row, "bias_hold_s"));
  TONUS_TRY_ASSIGN(event.bias_threshold_N, table.number_or_nothing(row, "bias_threshold_N"));
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
    if (cells.has("trial_type") && cells.cell(row, "trial_type") == kContraction)
      events.contractions_.push_back(row);
    if (cells.has("trial_type") && cells.cell(row, "trial_type") != kPerturbation) continue;
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
    auto event = read_perturbation(table_, rows_[i], recording);
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

Result<std::vector<PerturbationEvent>> EventTable::contractions(const Recording& recording,
                                                                Imperfect imperfect) const {
  std::vector<PerturbationEvent> contractions;
  for (const std::size_t row : contractions_) {
    auto event = read_common(table_, row, recording);
    const auto trial = table_.whole_number(row, "trial", 0);
    if (imperfect == Imperfect::kRefused) {
      if (!event) return event.error();
      if (!trial) return trial.error();
    }
    if (!event || !trial) continue;
    event->trial = *trial;
    contractions.push_back(*std::move(event));
  }
  std::ranges::stable_sort(contractions, {}, &PerturbationEvent::onset_s);
  return contractions;
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

constexpr const char* kNoteColumns = "\tnote\tnoted_by";

std::string perturbation_row(const PerturbationEvent& event) {
  std::string text;
  append_number(text, event.onset_s);
  text += '\t';
  append_number(text, event.duration_s);
  text += fmt::format("\t{}\t{}\t{}", kPerturbation, event.trial, event.set);
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
  return text;
}

std::string contraction_row(const PerturbationEvent& event) {
  std::string text;
  append_number(text, event.onset_s);
  text += '\t';
  append_number(text, event.duration_s);
  text += fmt::format("\t{}\t{}\tn/a\tn/a\tn/a\tn/a\tn/a\tn/a", kContraction, event.trial);
  text += event.is_valid ? "\ttrue\t" : "\tfalse\t";
  text += one_cell(event.reason) + '\t' + one_cell(event.instruction) + "\tn/a\tn/a";
  append_optional(text, event.trial_onset_s);
  append_optional(text, event.trial_duration_s);
  return text;
}

std::string note_row(const NoteEvent& note) {
  constexpr int kCellsOfPerturbations = 13;  // set to trial_duration_s
  std::string text;
  append_number(text, note.onset_s);
  text += "\t0\t" + note.kind + '\t' + (note.trial ? std::to_string(*note.trial) : "n/a");
  for (int i = 0; i < kCellsOfPerturbations; ++i) text += "\tn/a";
  return text + '\t' + one_cell(note.text) + '\t' + one_cell(note.written_by);
}

}  // namespace

std::string events_text(const Recording& recording) {
  const std::string no_note = recording.notes.empty() ? "" : "\tn/a\tn/a";
  std::vector<std::pair<double, std::string>> rows;
  for (const auto& event : recording.events)
    rows.emplace_back(event.onset_s, perturbation_row(event) + no_note);
  for (const auto& event : recording.contractions)
    rows.emplace_back(event.onset_s, contraction_row(event) + no_note);
  for (const auto& note : recording.notes) rows.emplace_back(note.onset_s, note_row(note));
  std::ranges::stable_sort(rows, {}, &std::pair<double, std::string>::first);
  std::string text = std::string(kColumns) + (recording.notes.empty() ? "" : kNoteColumns) + '\n';
  for (const auto& [onset, row] : rows) text += row + '\n';
  return text;
}

std::string events_json(const Recording& recording) {
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
  const bool has_notes = !recording.notes.empty();
  if (has_notes || !recording.contractions.empty()) {
    auto& levels = json["trial_type"]["Levels"];
    levels[kPerturbation] = "the hand was moved";
    if (!recording.contractions.empty())
      levels[kContraction] = "the subject contracted, and the handle was held still";
    if (has_notes) {
      levels["note"] = "an operator wrote a note, about the trial of that number if it has one";
      levels["marker"] = "an operator set a marker";
    }
  }
  if (has_notes) {
    describe_column("note", "What the operator wrote", "");
    describe_column("noted_by", "Who wrote it", "");
  }
  return json_text(json, 2) + "\n";
}

}  // namespace tonus::recording
