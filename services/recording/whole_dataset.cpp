#include <algorithm>
#include <optional>
#include <spdlog/fmt/fmt.h>
#include <vector>

#include "services/core/parallel.hpp"
#include "services/recording/dataset.hpp"
#include "services/recording/events.hpp"

namespace tonus::recording {
namespace {

std::vector<std::optional<Result<Recording>>> read_all(const Dataset& dataset) {
  std::vector<std::optional<Result<Recording>>> runs(dataset.runs());
  for_each_in_parallel(runs.size(), [&](std::size_t i) { runs[i] = dataset.read(i); });
  return runs;
}

/// Takes the recordings out that `keep` refuses; an error where it refuses all.
template <typename Keep>
Result<void> keep_only(UsableRecordings& usable, const Keep& keep) {
  std::optional<Error> first;
  std::erase_if(usable.recordings, [&](Recording& recording) {
    const Result<void> kept = keep(recording);
    if (kept) return false;
    if (!first) first = kept.error();
    usable.left_out.push_back(kept.error().message);
    return true;
  });
  if (first && usable.recordings.empty()) return *first;
  return {};
}

/// A continuous record's rows from its first event's to its last one's; those of no event are missing, and
/// reference contractions with them.
void cut_to_events(Recording& recording) {
  std::vector<bool> is_used(recording.rows.size(), false);
  for (const PerturbationEvent& event : recording.events) {
    if (!event.is_continuous()) return;
    const Stretch stretch = stretch_of(recording, event);
    std::fill(is_used.begin() + static_cast<std::ptrdiff_t>(stretch.first),
              is_used.begin() + static_cast<std::ptrdiff_t>(stretch.last) + 1, true);
  }
  const auto first = std::find(is_used.begin(), is_used.end(), true) - is_used.begin();
  const auto end = is_used.rend() - std::find(is_used.rbegin(), is_used.rend(), true);
  for (std::size_t i = 0; i < is_used.size(); ++i) {
    if (!is_used[i]) recording.rows[i].is_missing = true;
  }
  const auto cut = [&](auto& rows) {
    if (rows.empty()) return;
    rows.erase(rows.begin() + end, rows.end());
    rows.erase(rows.begin(), rows.begin() + first);
  };
  cut(recording.rows);
  cut(recording.commanded);
  cut(recording.phases);
  for (AuxiliarySeries& series : recording.auxiliary) {
    const auto values = static_cast<std::ptrdiff_t>(series.values_per_sample);
    series.values.erase(series.values.begin() + end * values, series.values.end());
    series.values.erase(series.values.begin(), series.values.begin() + first * values);
  }
  const std::int64_t trial = recording.events.front().trial;
  recording.events = {whole_record(recording, trial)};
  recording.contractions.clear();
}

}  // namespace

Result<std::vector<Recording>> read_dataset(const std::filesystem::path& root) {
  TONUS_TRY_ASSIGN(const auto dataset, Dataset::open(root));
  std::vector<Recording> recordings;
  for (auto& run : read_all(dataset)) {
    if (!*run) return run->error();
    recordings.push_back(std::move(**run));
  }
  return recordings;
}

Result<UsableRecordings> read_usable(const std::filesystem::path& root) {
  TONUS_TRY_ASSIGN(const auto dataset, Dataset::open(root, Imperfect::kLeftOut));
  UsableRecordings usable{{}, dataset.left_out()};
  std::optional<Error> first;
  for (auto& run : read_all(dataset)) {
    if (*run) {
      usable.recordings.push_back(std::move(**run));
      continue;
    }
    if (!first) first = run->error();
    usable.left_out.push_back(run->error().message);
  }
  if (first && usable.recordings.empty()) return *first;
  return usable;
}

Result<void> state_force_sign(UsableRecordings& usable, int sign) {
  return keep_only(usable, [&](Recording& recording) { return state_force_sign(recording, sign); });
}

Result<void> keep_what_counts(UsableRecordings& usable) {
  return keep_only(usable, [&](Recording& recording) -> Result<void> {
    std::optional<Error> last;
    std::erase_if(recording.events, [&](const PerturbationEvent& event) {
      if (event.is_valid) return false;
      last = fail(ErrorCode::kInvalidArgument,
                  fmt::format("{}, trial {}: {}", describe(recording), event.trial,
                              event.reason.empty() ? "flagged invalid" : event.reason));
      usable.left_out.push_back(last->message);
      return true;
    });
    if (recording.events.empty()) {
      return fail(ErrorCode::kInvalidArgument, describe(recording) + ": has no event that counts");
    }
    cut_to_events(recording);
    return {};
  });
}

}  // namespace tonus::recording
