#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "analysis_service/identification/condition.hpp"
#include "analysis_service/impedance/identification.hpp"

namespace tonus::identification {

/// Which raw rows a trial gave.
struct TrialSource {
  std::uint32_t attempt = 0;
  std::uint64_t epoch = 0;
  SequenceRange range;
  std::uint64_t onset = 0;
};

[[nodiscard]] TrialSource source_of(const TrialReport& report);

/// One analysis of one condition, with everything that it was made from.
struct ConditionEstimate {
  Condition condition;
  impedance::Options options;
  impedance::Estimate estimate;
  std::vector<TrialSource> trials;   ///< Behind the estimate, by attempt.
  std::uint32_t invalid_trials = 0;  ///< Of the condition, that were judged not to count.
  std::string refusal;               ///< Why there is no estimate at all; empty: there is one.
};

struct BookSettings {
  std::vector<impedance::Options> analyses{impedance::Options{}};  ///< Each is made for every condition.
  std::size_t most_trials = 1024;  ///< Of one condition; further ones are refused.
};

/// The trials of a session that count, by condition, and what is identified from them.
///
/// Law: identify() is impedance::identify on the condition's trials in the order of their attempts, the
/// function that the command line uses on recorded data; so the result depends, to the last bit, on which
/// trials there are and not on when or in which order they came and went. A condition that had a valid trial
/// once is identified even if none is left, so that nobody keeps what was published before. Trials without
/// bias count for all sets together; in a session that has biased trials also set by set. Not for use by
/// several threads.
class ConditionBook {
 public:
  explicit ConditionBook(BookSettings settings = {}) : settings_(std::move(settings)) {}

  /// What is made beside `analyses` where no analysis is by the same method, for the session that runs.
  void set_further(std::vector<impedance::Options> analyses) { further_ = std::move(analyses); }

  /// The session that runs ends its conditions when their intervals are narrow: those of method refined are
  /// widened by impedance::widen_by_process().
  void set_precision_led(bool is_precision_led) { is_precision_led_ = is_precision_led; }

  /// A trial that counts. An attempt that is here already stays as it is.
  /// kUnavailable: the condition has most_trials already.
  [[nodiscard]] Result<void> add_valid(const TrialReport& report, const impedance::Trial& trial);
  void add_invalid(const TrialReport& report);
  /// A trial that was valid does not count any more, and counts as invalid: its conditions have changed.
  /// Nothing happens where it is not among the valid ones.
  void withdraw(const Id& session, std::uint32_t attempt);

  /// Conditions whose trials changed since they were identified.
  [[nodiscard]] std::vector<Condition> changed() const { return {changed_.begin(), changed_.end()}; }

  /// One estimate an analysis; the condition is then no longer among the changed. None for an unknown
  /// condition.
  [[nodiscard]] std::vector<ConditionEstimate> identify(const Condition& condition);

  [[nodiscard]] std::vector<TrialSource> sources(const Condition& condition) const;
  /// Frees everything of other sessions.
  void keep_only(const Id& session);

 private:
  struct Entry {
    TrialSource source;
    impedance::Trial trial;
  };
  struct Page {
    std::map<std::uint32_t, Entry> valid;  // by attempt
    std::set<std::uint32_t> invalid;
    bool has_records = false;  // valid ones are or were continuous records
    bool has_had_valid = false;
    int axes = 2;
  };

  void insert(const Condition& condition, const TrialReport& report, const impedance::Trial& trial);
  void show_sets_of(const Id& session);
  void note_change(const Condition& condition);

  [[nodiscard]] std::vector<impedance::Options> analyses() const;

  BookSettings settings_;
  std::vector<impedance::Options> further_;
  bool is_precision_led_ = false;
  std::map<Condition, Page>
      pages_;  // also of single unloaded sets, which stay unseen until their session is loaded
  std::set<Id> loaded_sessions_;
  std::set<Condition> changed_;
};

}  // namespace tonus::identification
