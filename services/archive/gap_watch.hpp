#pragma once

#include <chrono>
#include <vector>

#include "services/core/clock.hpp"
#include "services/store/coverage.hpp"

namespace tonus::archive {

/// Decides when to ask for missing samples of one stream again. A gap is given `patience` to close by itself,
/// since samples may be on their way; then it is asked for, in pieces of at most `largest_request` samples. A
/// request that brings nothing is repeated at twice the interval each time, up to `slowest`; one that was
/// served in full is followed by the next piece at once. No thread and no clock of its own.
class GapWatch {
 public:
  struct Options {
    Clock::Duration patience = std::chrono::milliseconds(100);
    Clock::Duration slowest = std::chrono::seconds(10);
    std::uint64_t largest_request = 65536;
  };

  GapWatch() = default;
  explicit GapWatch(const Options& options) : options_(options) {}

  /// Tells what is missing now (ascending) and returns what to ask for now.
  [[nodiscard]] std::vector<store::SequenceRange> ask(const std::vector<store::SequenceRange>& missing,
                                                      Clock::TimePoint now);

  /// When the next gap is to be asked for; TimePoint::max() where nothing is missing.
  [[nodiscard]] Clock::TimePoint due() const;

  /// Forgets the requests that went unanswered: the rig is back.
  void start_anew() { gaps_.clear(); }

 private:
  struct Gap {
    store::SequenceRange range;
    Clock::TimePoint ask_at;
    Clock::Duration interval{};
    std::uint64_t asked_end = 0;  ///< End of the last piece asked for; 0: none yet.
  };

  [[nodiscard]] Gap follow(const store::SequenceRange& range, Clock::TimePoint now) const;

  Options options_;
  std::vector<Gap> gaps_;
};

}  // namespace tonus::archive
