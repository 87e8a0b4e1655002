#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "services/core/result.hpp"
#include "services/recording/recording.hpp"
#include "services/recording/table.hpp"

namespace tonus::recording {

/// The perturbations of an `_events.tsv` and the numbers of their trials, as far as they can be told without
/// the record's rows, and the reference contractions. `onset` and `duration` are needed; rows of another
/// trial_type are left out.
class EventTable {
 public:
  /// kInvalidArgument: besides what a Table refuses, no perturbation at all.
  [[nodiscard]] static Result<EventTable> read(const std::filesystem::path& file);

  /// In the order of the file; nothing where a trial has no number.
  [[nodiscard]] const std::vector<std::optional<std::int64_t>>& trials() const { return trials_; }
  void set_trial(std::size_t i, std::int64_t trial) { trials_[i] = trial; }

  /// All events by onset. Each must lie within the record, whose rows are there, to half a sample; one that
  /// does not, or has a cell that is not allowed, is refused, or there, not valid, with that as its reason.
  [[nodiscard]] Result<std::vector<PerturbationEvent>> events(const Recording& recording,
                                                              Imperfect imperfect) const;

  /// All reference contractions by onset, under the same rules.
  [[nodiscard]] Result<std::vector<PerturbationEvent>> contractions(const Recording& recording,
                                                                    Imperfect imperfect) const;

 private:
  explicit EventTable(Table table) : table_(std::move(table)) {}

  Table table_;
  std::vector<std::size_t> rows_;          // of perturbations
  std::vector<std::size_t> contractions_;  // rows
  std::vector<std::optional<std::int64_t>> trials_;
};

/// A continuous perturbation over the whole record.
[[nodiscard]] PerturbationEvent whole_record(const Recording& recording, std::int64_t trial);

/// Content of an `_events.tsv`: perturbations, reference contractions and notes by onset; only with notes
/// there are columns for those.
[[nodiscard]] std::string events_text(const Recording& recording);

/// Content of an `_events.json`: what the columns mean, and the trial types that this recording has beside
/// perturbations.
[[nodiscard]] std::string events_json(const Recording& recording);

}  // namespace tonus::recording
