#pragma once

#include <chrono>
#include <vector>

#include "services/archive/coverage.hpp"
#include "services/core/clock.hpp"

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
  [[nodiscard]] std::vector<SequenceRange> ask(const std::vector<SequenceRange>& missing,
                                               Clock::TimePoint now);

  /// When the next gap is to be asked for; TimePoint::max() where nothing is missing.
  [[nodiscard]] Clock::TimePoint due() const;

  /// Forgets how often was asked in vain: who can answer has come back.
  void start_anew() { gaps_.clear(); }

 private:
  struct Gap {
    SequenceRange range;
    Clock::TimePoint ask_at;
    Clock::Duration interval{};
    std::uint64_t asked_end = 0;  ///< End of the last piece asked for; 0: none yet.
  };

  [[nodiscard]] Gap follow(const SequenceRange& range, Clock::TimePoint now) const;

  Options options_;
  std::vector<Gap> gaps_;
};

}  // namespace tonus::archive
