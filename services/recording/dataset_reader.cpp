#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <spdlog/fmt/fmt.h>
#include <tuple>

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
constexpr double kFastestSampling = 1e6;  // Hz; faster is a wrong unit

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

/// Entries of a folder whose names start with `prefix`; none where there is no such folder.
std::vector<fs::path> entries(const fs::path& folder, std::string_view prefix) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().filename().string().starts_with(prefix)) found.push_back(entry->path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<fs::path> motion_files(const fs::path& root) {
  std::vector<fs::path> files;
  const auto take_folder = [&files](const fs::path& folder) {
    for (const fs::path& file : entries(folder / "motion", "sub-")) {
      if (file.filename().string().ends_with(kMotionSuffix)) files.push_back(file);
    }
  };
  for (const fs::path& participant : entries(root, "sub-")) {
    take_folder(participant);
    for (const fs::path& session : entries(participant, "ses-")) take_folder(session);
  }
  return files;
}

Result<void> read_motion_json(const fs::path& file, Recording& recording) {
  const auto json = JsonFile::read(file);
  if (!json) return json.error();
  const auto frequency = json->number("SamplingFrequency");
  if (!frequency) return frequency.error();
  if (!(*frequency > 0.0) || *frequency > kFastestSampling) {
    return json->refuse("SamplingFrequency",
                        fmt::format("more than 0 and up to {} Hz is needed", kFastestSampling));
  }
  const auto description = json->text("TaskDescription", "");
  if (!description) return description.error();
  recording.sampling_frequency = *frequency;
  recording.task_description = *description;
  return {};
}

/// The run's events file: with the tracking system in its name, or, as BIDS has it, for all tracking systems.
std::optional<fs::path> events_file(const fs::path& motion_file, const std::string& stem,
                                    const Recording& recording) {
  const fs::path own = stem + "_events.tsv";
  if (is_file(own)) return own;
  const std::string part = "_tracksys-" + recording.tracking_system;
  std::string name = own.filename().string();
  name.erase(name.find(part), part.size());
  const fs::path common = motion_file.parent_path() / name;
  if (is_file(common)) return common;
  return {};
}

Result<Recording> read_run(const fs::path& motion_file) {
  Recording recording;
  if (auto taken = take_labels(motion_file, recording); !taken) return taken.error();
  std::string stem = motion_file.string();
  stem.erase(stem.size() - kMotionSuffix.size());
  if (auto read = read_motion_json(stem + "_motion.json", recording); !read) return read.error();
  const auto columns = read_channels(stem, recording);
  if (!columns) return columns.error();
  if (auto read = read_rows(motion_file, *columns, recording); !read) return read.error();
  if (const auto file = events_file(motion_file, stem, recording)) {
    auto events = read_events(*file, recording);
    if (!events) return events.error();
    if (events->empty()) {
      return fail(ErrorCode::kInvalidArgument,
                  file->string() + ": has no row of trial_type perturbation: one is needed");
    }
    recording.events = std::move(*events);
  }
  return recording;
}

/// Trial numbers: unique in a session where stated, the next free ones for records without events.
Result<void> number_trials(std::vector<Recording>& recordings) {
  std::map<std::pair<std::string, std::string>, std::set<std::int64_t>> taken;
  for (const Recording& recording : recordings) {
    auto& trials = taken[{recording.participant.id, recording.session}];
    for (const PerturbationEvent& event : recording.events) {
      if (trials.insert(event.trial).second) continue;
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("events of {}: trial {} is there twice: a number may stand once in a session",
                              describe(recording), event.trial));
    }
  }
  for (Recording& recording : recordings) {
    if (!recording.events.empty()) continue;
    auto& trials = taken[{recording.participant.id, recording.session}];
    const std::int64_t next = trials.empty() ? 1 : *trials.rbegin() + 1;
    trials.insert(next);
    recording.events.push_back(whole_record(recording, next));
  }
  return {};
}

Result<void> take_participants(const fs::path& root, std::vector<Recording>& recordings) {
  const fs::path file = root / "participants.tsv";
  if (!is_file(file)) return {};
  const auto participants = read_participants(file);
  if (!participants) return participants.error();
  for (Recording& recording : recordings) {
    const auto known = participants->find(recording.participant.id);
    if (known == participants->end()) {
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("{}: participant '{}' is missing: the dataset has its recordings",
                              file.string(), recording.participant.id));
    }
    recording.participant = known->second;
  }
  return {};
}

}  // namespace

Result<std::vector<Recording>> read_dataset(const fs::path& root) {
  std::error_code error;
  if (!fs::is_directory(root, error)) {
    return fail(
        ErrorCode::kNotFound,
        fmt::format("dataset '{}': no such folder: the root of a BIDS dataset is needed", root.string()));
  }
  if (!is_file(root / "dataset_description.json")) {
    return fail(ErrorCode::kNotFound,
                fmt::format("dataset '{}': is not a BIDS dataset: dataset_description.json is missing",
                            root.string()));
  }
  if (const auto description = JsonFile::read(root / "dataset_description.json"); !description)
    return description.error();
  const std::vector<fs::path> files = motion_files(root);
  if (files.empty()) {
    return fail(ErrorCode::kNotFound,
                fmt::format("dataset '{}': has no recording: sub-*/[ses-*/]motion/*_motion.tsv is needed",
                            root.string()));
  }
  std::vector<std::optional<Result<Recording>>> runs(files.size());
  for_each_in_parallel(files.size(), [&](std::size_t i) { runs[i] = read_run(files[i]); });
  std::vector<Recording> recordings;
  for (auto& run : runs) {
    if (!*run) return run->error();
    recordings.push_back(std::move(**run));
  }
  const auto labels = [](const Recording& recording) {
    return std::tie(recording.participant.id, recording.session, recording.task, recording.acquisition,
                    recording.run, recording.tracking_system);
  };
  std::stable_sort(recordings.begin(), recordings.end(),
                   [&labels](const Recording& a, const Recording& b) { return labels(a) < labels(b); });
  if (auto taken = take_participants(root, recordings); !taken) return taken.error();
  if (auto numbered = number_trials(recordings); !numbered) return numbered.error();
  return recordings;
}

}  // namespace tonus::recording
