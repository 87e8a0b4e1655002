#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <spdlog/fmt/fmt.h>
#include <tuple>

#include "services/core/folder.hpp"
#include "services/core/parallel.hpp"
#include "services/recording/channels.hpp"
#include "services/recording/dataset.hpp"
#include "services/recording/events.hpp"
#include "services/recording/file_name.hpp"
#include "services/recording/json_file.hpp"
#include "services/recording/motion_rows.hpp"
#include "services/recording/participants.hpp"

namespace tonus::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMotionSuffix = "_motion.tsv";
constexpr double kFastestSampling = 1e6;     // Hz; faster is a wrong unit
constexpr double kEffectiveTolerance = 0.1;  // of the nominal rate, that the effective one may depart
constexpr double kDurationTolerance = 0.01;  // of the duration that the rows have

/// Entries of a folder whose names start with `prefix`; none where there is no such folder.
Result<std::vector<fs::path>> entries(const fs::path& folder, std::string_view prefix) {
  std::vector<fs::path> found;
  TONUS_TRY_ASSIGN(const bool is_there, is_present(folder));
  if (!is_there) return found;
  TONUS_TRY_ASSIGN(auto all, list_folder(folder));
  for (fs::path& path : all) {
    if (path.filename().string().starts_with(prefix)) found.push_back(std::move(path));
  }
  return found;
}

Result<void> take_motion_files(const fs::path& folder, std::vector<fs::path>& files) {
  TONUS_TRY_ASSIGN(const auto found, entries(folder / "motion", "sub-"));
  for (const fs::path& file : found) {
    if (file.filename().string().ends_with(kMotionSuffix)) files.push_back(file);
  }
  return {};
}

Result<std::vector<fs::path>> motion_files(const fs::path& root) {
  std::vector<fs::path> files;
  TONUS_TRY_ASSIGN(const auto participants, entries(root, "sub-"));
  for (const fs::path& participant : participants) {
    std::error_code error;
    if (fs::is_regular_file(participant, error)) continue;
    TONUS_TRY(take_motion_files(participant, files));
    TONUS_TRY_ASSIGN(const auto sessions, entries(participant, "ses-"));
    for (const fs::path& session : sessions) {
      if (!fs::is_regular_file(session, error)) TONUS_TRY(take_motion_files(session, files));
    }
  }
  return files;
}

/// Folders of a dataset that BIDS gives another meaning, and those of other programs (.git).
bool is_beside(const fs::path& folder) {
  const std::string name = folder.filename().string();
  return name.starts_with('.') || name == "sourcedata" || name == "derivatives" || name == "code" ||
         name == "stimuli";
}

bool is_motion_file(const std::string& name) {
  return name.find("_motion.tsv") != std::string::npos || name.ends_with("motion.tsv");
}

/// A recording that lies where BIDS does not have it, or is compressed, would be lost without a word. Links
/// to folders are not followed: what they lead to is another dataset's.
Result<void> refuse_misplaced(const fs::path& folder, const std::vector<fs::path>& read) {
  TONUS_TRY_ASSIGN(const auto entries, list_folder(folder));
  for (const fs::path& entry : entries) {
    std::error_code error;
    if (fs::symlink_status(entry, error).type() == fs::file_type::directory) {
      if (!is_beside(entry)) TONUS_TRY(refuse_misplaced(entry, read));
      continue;
    }
    if (!is_motion_file(entry.filename().string())) continue;
    if (std::find(read.begin(), read.end(), entry) != read.end()) continue;
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("{}: a recording is not allowed here; expected sub-*/[ses-*/]motion/"
                            "sub-*_motion.tsv, not compressed",
                            entry.string()));
  }
  return {};
}

/// What `_motion.json` says of time and of missing values beyond the rate that is used.
struct MotionNotes {
  double nominal_rate = 0.0;       ///< Hz, SamplingFrequency.
  std::optional<double> duration;  ///< s, RecordingDuration.
  std::string missing_value;       ///< Of MissingValues; empty: none but n/a.
};

Result<MotionNotes> read_motion_json(const fs::path& file, Recording& recording) {
  TONUS_TRY_ASSIGN(const auto json, JsonFile::read(file));
  TONUS_TRY_ASSIGN(const auto frequency, json.number("SamplingFrequency"));
  if (!(frequency > 0.0) || frequency > kFastestSampling) {
    return json.refuse("SamplingFrequency", fmt::format("more than 0 and up to {} Hz", kFastestSampling));
  }
  TONUS_TRY_ASSIGN(const auto description, json.text("TaskDescription", ""));
  MotionNotes notes;
  notes.nominal_rate = frequency;
  TONUS_TRY_ASSIGN(const auto effective, json.number("SamplingFrequencyEffective", frequency));
  if (!(std::abs(effective - frequency) <= kEffectiveTolerance * frequency)) {
    return json.refuse(
        "SamplingFrequencyEffective",
        fmt::format("within {} % of the SamplingFrequency, {} Hz", 100.0 * kEffectiveTolerance, frequency));
  }
  if (json.has("RecordingDuration")) {
    TONUS_TRY_ASSIGN(const auto duration, json.number("RecordingDuration"));
    notes.duration = duration;
  }
  if (const auto missing = json.text("MissingValues", "")) notes.missing_value = *missing;
  if (notes.missing_value == "none") notes.missing_value.clear();
  recording.sampling_frequency = effective;
  recording.task_description = description;
  return notes;
}

/// RecordingDuration and the rows at the rate that is used say the same time.
Result<void> check_duration(const fs::path& file, const MotionNotes& notes, const Recording& recording) {
  if (!notes.duration) return {};
  const double found = static_cast<double>(recording.rows.size()) / recording.sampling_frequency;
  const double allowed = kDurationTolerance * found + 2.0 / recording.sampling_frequency;
  if (std::abs(found - *notes.duration) <= allowed) return {};
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("{}: {} rows at {:.6g} Hz, {:.6g} s, are not allowed; expected {:.6g} s, the "
                          "RecordingDuration of _motion.json",
                          file.string(), recording.rows.size(), recording.sampling_frequency, found,
                          *notes.duration));
}

/// The run's events file: with the tracking system in its name, or, as BIDS has it, for all tracking systems.
Result<std::optional<fs::path>> events_file(const fs::path& motion_file, const std::string& stem,
                                            const Recording& recording) {
  const fs::path own = stem + "_events.tsv";
  TONUS_TRY_ASSIGN(const bool has_own, is_present(own));
  if (has_own) return std::optional(own);
  const std::string part = "_tracksys-" + recording.tracking_system;
  std::string name = own.filename().string();
  name.erase(name.find(part), part.size());
  const fs::path common = motion_file.parent_path() / name;
  TONUS_TRY_ASSIGN(const bool has_common, is_present(common));
  return has_common ? std::optional(common) : std::nullopt;
}

Result<void> check_root(const fs::path& root) {
  TONUS_TRY_ASSIGN(const bool is_there, is_present(root));
  std::error_code ignored;
  if (!is_there || !fs::is_directory(root, ignored)) {
    return fail(
        ErrorCode::kNotFound,
        fmt::format("dataset '{}': no such folder; expected the root of a BIDS dataset", root.string()));
  }
  TONUS_TRY_ASSIGN(const bool is_described, is_present(root / "dataset_description.json"));
  if (!is_described) {
    return fail(ErrorCode::kNotFound,
                fmt::format("dataset '{}': is not a BIDS dataset: dataset_description.json is missing",
                            root.string()));
  }
  TONUS_TRY(JsonFile::read(root / "dataset_description.json"));
  return {};
}

Result<void> take_participant(const fs::path& file, const std::map<std::string, Participant>& participants,
                              Recording& header) {
  const auto known = participants.find(header.participant.id);
  if (known == participants.end()) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("{}: participant '{}' is missing; expected a row, as the dataset has recordings of it",
                    file.string(), header.participant.id));
  }
  header.participant = known->second;
  return {};
}

}  // namespace

/// What a recording is read from.
struct Dataset::Run {
  Recording header;  ///< Everything but rows and events.
  fs::path motion_file;
  MotionNotes notes;
  std::vector<Column> columns;
  std::optional<EventTable> events;
  std::int64_t whole_trial = 0;  ///< Number of the one trial of a record without events.
};

Dataset::Dataset(std::vector<Run> runs) : runs_(std::move(runs)) {}
Dataset::Dataset(Dataset&&) noexcept = default;
Dataset& Dataset::operator=(Dataset&&) noexcept = default;
Dataset::~Dataset() = default;

std::size_t Dataset::runs() const { return runs_.size(); }

Result<Dataset::Run> Dataset::open_run(const fs::path& motion_file) {
  Run run;
  run.motion_file = motion_file;
  TONUS_TRY(take_labels(motion_file, run.header));
  std::string stem = motion_file.string();
  stem.erase(stem.size() - kMotionSuffix.size());
  TONUS_TRY_ASSIGN(run.notes, read_motion_json(stem + "_motion.json", run.header));
  TONUS_TRY_ASSIGN(run.columns, read_channels(stem, run.header, run.notes.nominal_rate));
  TONUS_TRY_ASSIGN(const auto events, events_file(motion_file, stem, run.header));
  if (events) {
    TONUS_TRY_ASSIGN(run.events, EventTable::read(*events));
  }
  return run;
}

/// Trial numbers: unique in a session where stated, the next free ones for records without events.
Result<void> Dataset::number_trials(std::vector<Run>& runs) {
  std::map<std::pair<std::string, std::string>, std::set<std::int64_t>> taken;
  const auto trials_of = [&taken](const Run& run) -> auto& {
    return taken[{run.header.participant.id, run.header.session}];
  };
  for (const Run& run : runs) {
    if (!run.events) continue;
    for (const std::int64_t trial : run.events->trials()) {
      if (trials_of(run).insert(trial).second) continue;
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("events of {}: trial {} occurs twice; expected once in a session",
                              describe(run.header), trial));
    }
  }
  for (Run& run : runs) {
    if (run.events) continue;
    auto& trials = trials_of(run);
    run.whole_trial = trials.empty() ? 1 : *trials.rbegin() + 1;
    trials.insert(run.whole_trial);
  }
  return {};
}

Result<Dataset> Dataset::open(const fs::path& root) {
  TONUS_TRY(check_root(root));
  TONUS_TRY_ASSIGN(const auto files, motion_files(root));
  TONUS_TRY(refuse_misplaced(root, files));
  if (files.empty()) {
    return fail(ErrorCode::kNotFound,
                fmt::format("dataset '{}': has no recording; expected sub-*/[ses-*/]motion/*_motion.tsv",
                            root.string()));
  }
  std::vector<Run> runs;
  for (const fs::path& file : files) {
    TONUS_TRY_ASSIGN(auto run, open_run(file));
    runs.push_back(std::move(run));
  }
  const auto labels = [](const Recording& header) {
    return std::tie(header.participant.id, header.session, header.task, header.acquisition, header.run,
                    header.tracking_system);
  };
  std::stable_sort(runs.begin(), runs.end(),
                   [&labels](const Run& a, const Run& b) { return labels(a.header) < labels(b.header); });
  const fs::path file = root / "participants.tsv";
  TONUS_TRY_ASSIGN(const bool has_participants, is_present(file));
  if (has_participants) {
    TONUS_TRY_ASSIGN(const auto participants, read_participants(file));
    for (Run& run : runs) {
      TONUS_TRY(take_participant(file, participants, run.header));
    }
  }
  TONUS_TRY(number_trials(runs));
  return Dataset(std::move(runs));
}

Result<Recording> Dataset::read(std::size_t index) const {
  const Run& run = runs_[index];
  Recording recording = run.header;
  TONUS_TRY(read_rows(run.motion_file, run.columns, run.notes.missing_value, recording));
  TONUS_TRY(check_duration(run.motion_file, run.notes, recording));
  if (!run.events) {
    recording.events.push_back(whole_record(recording, run.whole_trial));
    return recording;
  }
  TONUS_TRY_ASSIGN(recording.events, run.events->events(recording));
  return recording;
}

Result<std::vector<Recording>> read_dataset(const fs::path& root) {
  TONUS_TRY_ASSIGN(const auto dataset, Dataset::open(root));
  std::vector<std::optional<Result<Recording>>> runs(dataset.runs());
  for_each_in_parallel(runs.size(), [&](std::size_t i) { runs[i] = dataset.read(i); });
  std::vector<Recording> recordings;
  for (auto& run : runs) {
    if (!*run) return run->error();
    recordings.push_back(std::move(**run));
  }
  return recordings;
}

}  // namespace tonus::recording
