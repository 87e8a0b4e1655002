#include <algorithm>

#include "services/bus/memory/fabric_state.hpp"

namespace tonus::bus {

void SampleQueue::push(const Sample& sample) {
  const auto depth = static_cast<std::ptrdiff_t>(qos_.depth);
  if (qos_.history == History::kKeepLast) {
    const auto same_key = [&](const Sample& held) { return held.key == sample.key; };
    if (std::count_if(samples_.begin(), samples_.end(), same_key) >= depth) {
      samples_.erase(std::find_if(samples_.begin(), samples_.end(), same_key));
    }
  }
  samples_.push_back(sample);
}

bool SampleQueue::is_full() const {
  return qos_.history == History::kKeepAll && samples_.size() >= static_cast<std::size_t>(qos_.depth);
}

void DeadlineWatch::seen(const Key& key, SteadyTime now) {
  if (deadline_.count() > 0) due_[key] = now + deadline_;
}

bool DeadlineWatch::expire(SteadyTime now) {
  bool has_missed = false;
  for (auto& [key, due] : due_) {
    for (; due <= now; due += deadline_) {
      ++missed_;
      has_missed = true;
    }
  }
  return has_missed;
}

std::optional<SteadyTime> DeadlineWatch::next() const {
  std::optional<SteadyTime> earliest;
  for (const auto& [key, due] : due_) {
    if (!earliest || due < *earliest) earliest = due;
  }
  return earliest;
}

}  // namespace tonus::bus
