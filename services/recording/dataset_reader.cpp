#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <spdlog/fmt/fmt.h>
#include <tuple>

#include "services/core/folder.hpp"
#include "services/recording/auxiliary_files.hpp"
#include "services/recording/channels.hpp"
#include "services/recording/dataset.hpp"
#include "services/recording/events.hpp"
#include "services/recording/file_name.hpp"
#include "services/recording/inherited_files.hpp"
#include "services/recording/json_file.hpp"
#include "services/recording/motion_rows.hpp"
#include "services/recording/participants.hpp"
#include "services/recording/sessions.hpp"

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

/// Adds a line for each recording that lies where BIDS does not have it, or is compressed: it would be lost
/// without a word. Links to folders are not followed: what they lead to is another dataset's.
Result<void> find_misplaced(const fs::path& folder, const std::vector<fs::path>& read,
                            std::vector<std::string>& found) {
  TONUS_TRY_ASSIGN(const auto entries, list_folder(folder));
  for (const fs::path& entry : entries) {
    std::error_code error;
    if (fs::symlink_status(entry, error).type() == fs::file_type::directory) {
      if (!is_beside(entry)) TONUS_TRY(find_misplaced(entry, read, found));
      continue;
    }
    if (!is_motion_file(entry.filename().string())) continue;
    if (std::find(read.begin(), read.end(), entry) != read.end()) continue;
    found.push_back(
        fmt::format("{}: a recording is not allowed here; expected sub-*/[ses-*/]motion/"
                    "sub-*_motion.tsv, not compressed",
                    entry.string()));
  }
  return {};
}

/// The run's file of that suffix, in its own folder and with all of its entities.
fs::path own_file(const fs::path& motion_file, std::string_view suffix) {
  std::string name = motion_file.string();
  name.replace(name.size() - kMotionSuffix.size() + 1, std::string::npos, suffix);
  return name;
}

/// What `_motion.json` says of time and of missing values beyond the rate that is used.
struct MotionNotes {
  double nominal_rate = 0.0;       ///< Hz, SamplingFrequency.
  std::optional<double> duration;  ///< s, RecordingDuration.
  std::string missing_value;       ///< Of MissingValues; empty: none but n/a.
};

Result<MotionNotes> read_motion_json(InheritedFiles& inherited, const fs::path& motion_file,
                                     Recording& recording) {
  TONUS_TRY_ASSIGN(auto files, inherited.of(motion_file, "motion.json"));
  if (files.empty()) files.push_back(own_file(motion_file, "motion.json"));
  TONUS_TRY_ASSIGN(const auto json, JsonFile::read(files));
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

/// Files of auxiliary channels, by the run that they belong to: its path without the tracking system.
using AuxiliaryPaths = std::map<std::string, std::vector<fs::path>>;

constexpr std::string_view kTrackingSystem = "_tracksys-";

/// The label in a file's name; empty: it has none.
std::string_view tracking_system_in(std::string_view name) {
  const auto at = name.find(kTrackingSystem);
  if (at == std::string_view::npos) return {};
  const auto rest = name.substr(at + kTrackingSystem.size());
  return rest.substr(0, rest.find('_'));
}

std::string without_tracking_system(const fs::path& motion_file) {
  std::string name = motion_file.filename().string();
  const std::string part = std::string(kTrackingSystem) + std::string(tracking_system_in(name));
  if (const auto at = name.find(part); at != std::string::npos) name.erase(at, part.size());
  return (motion_file.parent_path() / name).string();
}

/// Takes them out of `files`.
AuxiliaryPaths take_auxiliary_files(std::vector<fs::path>& files) {
  AuxiliaryPaths taken;
  std::erase_if(files, [&](const fs::path& file) {
    if (auxiliary_values_of(tracking_system_in(file.filename().string())) == 0) return false;
    taken[without_tracking_system(file)].push_back(file);
    return true;
  });
  return taken;
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

/// The sidecar of a run, from all files that apply to it; where none does, its own, which is not there.
Result<JsonFile> read_sidecar(InheritedFiles& inherited, const fs::path& motion_file,
                              std::string_view suffix) {
  TONUS_TRY_ASSIGN(const auto files, inherited.of(motion_file, suffix));
  return files.empty() ? JsonFile(own_file(motion_file, suffix)) : JsonFile::read(files);
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

/// A run that is left out, by its name, whichever of its files is the reason.
std::string name_with(const fs::path& motion_file, const fs::path& root, const Error& error) {
  const std::string name = motion_file.lexically_relative(root).string();
  return error.message.find(name) != std::string::npos ? error.message : name + ": " + error.message;
}

}  // namespace

/// What a recording is read from.
struct Dataset::Run {
  Recording header;  ///< Everything but rows and events.
  fs::path motion_file;
  MotionNotes notes;
  Columns columns;
  std::vector<AuxiliaryFile> auxiliary;
  std::optional<EventTable> events;
  std::int64_t whole_trial = 0;  ///< Number of the one trial of a record without events.

  /// Takes those files of auxiliary channels that are this run's.
  Result<void> add_auxiliary(AuxiliaryPaths& files);
};

Result<void> Dataset::Run::add_auxiliary(AuxiliaryPaths& files) {
  const auto own = files.extract(without_tracking_system(motion_file));
  if (own.empty()) return {};
  for (const fs::path& file : own.mapped()) {
    const auto values = auxiliary_values_of(tracking_system_in(file.filename().string()));
    TONUS_TRY_ASSIGN(auto opened, open_auxiliary(file, values, header.sampling_frequency));
    auxiliary.push_back(std::move(opened));
  }
  return {};
}

Dataset::Dataset(std::vector<Run> runs, std::vector<std::string> left_out, Imperfect imperfect)
    : runs_(std::move(runs)), left_out_(std::move(left_out)), imperfect_(imperfect) {}
Dataset::Dataset(Dataset&&) noexcept = default;
Dataset& Dataset::operator=(Dataset&&) noexcept = default;
Dataset::~Dataset() = default;

std::size_t Dataset::runs() const { return runs_.size(); }

Result<Dataset::Run> Dataset::open_run(const fs::path& motion_file, InheritedFiles& inherited) {
  Run run;
  run.motion_file = motion_file;
  TONUS_TRY(take_labels(motion_file, run.header));
  TONUS_TRY_ASSIGN(run.notes, read_motion_json(inherited, motion_file, run.header));
  TONUS_TRY_ASSIGN(const auto tables, inherited.of(motion_file, "channels.tsv"));
  TONUS_TRY_ASSIGN(const auto json, read_sidecar(inherited, motion_file, "channels.json"));
  const fs::path table = tables.empty() ? own_file(motion_file, "channels.tsv") : tables.back();
  TONUS_TRY_ASSIGN(run.columns, read_channels(table, json, run.header, run.notes.nominal_rate));
  TONUS_TRY_ASSIGN(const auto events, inherited.of(motion_file, "events.tsv"));
  if (!events.empty()) {
    TONUS_TRY_ASSIGN(run.events, EventTable::read(events.back()));
  }
  return run;
}

/// What `participants.tsv` says of those whose runs there are. Where imperfect items are left out, it goes to
/// `left_out`, and of such a participant no more than the id is known.
Result<void> Dataset::take_participants(const fs::path& file, std::vector<Run>& runs,
                                        std::vector<std::string>* left_out) {
  const auto leave_out = [left_out](Error error) -> Result<void> {
    if (left_out == nullptr) return error;
    if (std::ranges::find(*left_out, error.message) == left_out->end()) left_out->push_back(error.message);
    return {};
  };
  TONUS_TRY_ASSIGN(const bool has_participants, is_present(file));
  if (!has_participants) return {};
  const auto participants = read_participants(file, left_out);
  if (!participants) return leave_out(participants.error());
  for (Run& run : runs) {
    const auto known = participants->find(run.header.participant.id);
    if (known != participants->end()) {
      run.header.participant = known->second;
      continue;
    }
    TONUS_TRY(leave_out(fail(
        ErrorCode::kInvalidArgument,
        fmt::format("{}: participant '{}' is missing; expected a row, as the dataset has recordings of it",
                    file.string(), run.header.participant.id))));
  }
  return {};
}

/// What is said of each session as a whole.
Result<void> Dataset::take_sessions(const fs::path& root, std::vector<Run>& runs,
                                    std::vector<std::string>* left_out) {
  std::map<std::string, std::map<std::string, SessionFacts>> known;
  for (Run& run : runs) {
    const std::string& participant = run.header.participant.id;
    if (!known.contains(participant)) {
      auto sessions = read_sessions(sessions_file(root, participant));
      if (!sessions && left_out == nullptr) return sessions.error();
      if (!sessions) left_out->push_back(sessions.error().message);
      known[participant] = sessions ? std::move(*sessions) : std::map<std::string, SessionFacts>();
    }
    const auto session = known[participant].find(run.header.session);
    if (session != known[participant].end()) run.header.session_facts = session->second;
  }
  return {};
}

/// Trial numbers: unique in a session where stated (in a run, where the imperfect is left out), the next free
/// ones for trials and records without one.
Result<void> Dataset::number_trials(std::vector<Run>& runs, Imperfect imperfect) {
  std::map<std::tuple<std::string, std::string, std::size_t>, std::set<std::int64_t>> taken;
  const auto trials_of = [&](std::size_t i) -> auto& {
    const Recording& header = runs[i].header;
    return taken[{header.participant.id, header.session, imperfect == Imperfect::kRefused ? 0 : i}];
  };
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!runs[i].events) continue;
    for (const auto trial : runs[i].events->trials()) {
      if (!trial || trials_of(i).insert(*trial).second) continue;
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("events of {}: trial {} occurs twice; expected once in a session",
                              describe(runs[i].header), *trial));
    }
  }
  for (std::size_t i = 0; i < runs.size(); ++i) {
    auto& trials = trials_of(i);
    const auto next = [&trials] {
      return *trials.insert(trials.empty() ? 1 : std::max<std::int64_t>(0, *trials.rbegin()) + 1).first;
    };
    if (!runs[i].events) {
      runs[i].whole_trial = next();
      continue;
    }
    for (std::size_t row = 0; row < runs[i].events->trials().size(); ++row) {
      if (!runs[i].events->trials()[row]) runs[i].events->set_trial(row, next());
    }
  }
  return {};
}

Result<Dataset> Dataset::open(const fs::path& root, Imperfect imperfect) {
  const bool is_left_out = imperfect == Imperfect::kLeftOut;
  TONUS_TRY(check_root(root));
  TONUS_TRY_ASSIGN(auto files, motion_files(root));
  std::vector<std::string> left_out;
  TONUS_TRY(find_misplaced(root, files, left_out));
  AuxiliaryPaths auxiliary = take_auxiliary_files(files);
  if (!left_out.empty() && (files.empty() || !is_left_out))
    return fail(ErrorCode::kInvalidArgument, left_out.front());
  if (files.empty()) {
    return fail(ErrorCode::kNotFound,
                fmt::format("dataset '{}': has no recording; expected sub-*/[ses-*/]motion/*_motion.tsv",
                            root.string()));
  }
  InheritedFiles inherited(root);
  std::vector<Run> runs;
  std::optional<Error> first;
  for (const fs::path& file : files) {
    auto run = open_run(file, inherited);
    if (run) {
      if (const auto added = run->add_auxiliary(auxiliary); !added) run = added.error();
    }
    if (run) {
      runs.push_back(*std::move(run));
      continue;
    }
    if (!is_left_out) return run.error();
    if (!first) first = run.error();
    left_out.push_back(name_with(file, root, run.error()));
  }
  if (runs.empty()) return *first;
  for (const auto& [stem, lost] : auxiliary) {
    for (const fs::path& file : lost) {
      const Error error =
          fail(ErrorCode::kNotFound,
               fmt::format("{}: has channels of a recording that is not there", file.string()));
      if (!is_left_out) return error;
      left_out.push_back(error.message);
    }
  }
  const auto labels = [](const Recording& header) {
    return std::tie(header.participant.id, header.session, header.task, header.acquisition, header.run,
                    header.tracking_system);
  };
  std::stable_sort(runs.begin(), runs.end(),
                   [&labels](const Run& a, const Run& b) { return labels(a.header) < labels(b.header); });
  TONUS_TRY(take_participants(root / "participants.tsv", runs, is_left_out ? &left_out : nullptr));
  TONUS_TRY(take_sessions(root, runs, is_left_out ? &left_out : nullptr));
  TONUS_TRY(number_trials(runs, imperfect));
  return Dataset(std::move(runs), std::move(left_out), imperfect);
}

Result<Recording> Dataset::read(std::size_t index) const {
  const Run& run = runs_[index];
  Recording recording = run.header;
  TONUS_TRY(read_rows(run.motion_file, run.columns, run.notes.missing_value, recording));
  TONUS_TRY(check_duration(run.motion_file, run.notes, recording));
  TONUS_TRY(read_auxiliary(run.auxiliary, recording));
  if (!run.events) {
    recording.events.push_back(whole_record(recording, run.whole_trial));
    return recording;
  }
  TONUS_TRY_ASSIGN(recording.events, run.events->events(recording, imperfect_));
  TONUS_TRY_ASSIGN(recording.contractions, run.events->contractions(recording, imperfect_));
  return recording;
}

}  // namespace tonus::recording
