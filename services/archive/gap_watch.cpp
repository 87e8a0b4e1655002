#include "services/archive/gap_watch.hpp"

#include <algorithm>

namespace tonus::archive {

std::vector<store::SequenceRange> GapWatch::ask(const std::vector<store::SequenceRange>& missing,
                                                Clock::TimePoint now) {
  std::vector<Gap> gaps;
  std::vector<store::SequenceRange> requests;
  for (const store::SequenceRange& range : missing) {
    Gap gap = follow(range, now);
    if (gap.ask_at <= now) {
      gap.asked_end = std::min(range.end, range.first + options_.largest_request);
      gap.ask_at = now + gap.interval;
      gap.interval = std::min(2 * gap.interval, options_.slowest);
      requests.push_back({range.first, gap.asked_end});
    }
    gaps.push_back(gap);
  }
  gaps_ = std::move(gaps);
  return requests;
}

GapWatch::Gap GapWatch::follow(const store::SequenceRange& range, Clock::TimePoint now) const {
  Gap gap{range, now + options_.patience, options_.patience, 0};
  const auto before = std::find_if(gaps_.begin(), gaps_.end(), [&range](const Gap& known) {
    return known.range.first <= range.first && range.first < known.range.end;
  });
  if (before == gaps_.end()) return gap;
  if (before->range.first == range.first) {
    gap = *before;
    gap.range = range;
    return gap;
  }
  gap.asked_end = before->asked_end;
  const bool is_served = gap.asked_end != 0 && gap.asked_end <= range.first;
  if (is_served) gap.ask_at = now;
  return gap;
}

Clock::TimePoint GapWatch::due() const {
  Clock::TimePoint earliest = Clock::TimePoint::max();
  for (const Gap& gap : gaps_) earliest = std::min(earliest, gap.ask_at);
  return earliest;
}

}  // namespace tonus::archive
