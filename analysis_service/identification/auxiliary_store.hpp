#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <vector>

#include "analysis_service/identification/measured_trial.hpp"

namespace tonus::identification {

/// Values of the auxiliary channels of trials that are not judged yet, in whatever order they came. Holds a
/// bounded number of values; beyond it the oldest blocks give way. Not for use by several threads.
class AuxiliaryStore {
 public:
  /// Takes a block of a trial; others, and those of trials that are done, are left out.
  void add(const AuxiliaryRows& block);

  /// Which rows of a trial have no values here, ascending.
  [[nodiscard]] std::vector<SequenceRange> missing(const TrialReport& report) const;

  /// The trial's series; NaN where nothing came. A block that does not fit the channels counts as not there.
  [[nodiscard]] std::vector<AuxiliarySeries> series_of(const TrialReport& report,
                                                       std::span<const AuxiliaryChannel> channels) const;

  /// The trial is judged: its values are freed and no more are taken.
  void finish(const Id& trial);

  [[nodiscard]] std::size_t values() const { return values_; }

 private:
  struct Block {
    Id trial{};
    std::uint64_t epoch = 0;
    SequenceRange range;
    std::vector<float> values;
  };

  std::deque<Block> blocks_;  // in the order of their coming
  std::deque<Id> done_;
  std::size_t values_ = 0;
};

}  // namespace tonus::identification
