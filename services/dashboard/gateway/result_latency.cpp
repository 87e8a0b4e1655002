#include "services/dashboard/gateway/result_latency.hpp"

#include <utility>

namespace tonus::dashboard {
namespace {

constexpr std::size_t kOutcomesKept = 256;

}  // namespace

void Histogram::add(double seconds) {
  ++count_;
  sum_ += seconds;
  for (std::size_t i = 0; i < kEnds.size(); ++i) within_[i] += seconds <= kEnds[i] ? 1 : 0;
}

void ResultLatency::note_outcome(const Id& trial, std::uint64_t written_ns) {
  if (!trials_.try_emplace(trial, Trial{written_ns}).second) return;
  order_.push_back(trial);
  if (order_.size() <= kOutcomesKept) return;
  trials_.erase(order_.front());
  order_.pop_front();
}

void ResultLatency::note(const Id& trial, std::uint64_t written_ns, bool Trial::*has, Histogram& histogram) {
  const auto found = trials_.find(trial);
  if (found == trials_.end() || std::exchange(found->second.*has, true)) return;
  // Where the clocks of two hosts differ by more than it took, it is not known how long that was.
  if (written_ns >= found->second.ended_ns)
    histogram.add(1e-9 * static_cast<double>(written_ns - found->second.ended_ns));
}

void ResultLatency::note_verdict(const Id& trial, std::uint64_t written_ns) {
  note(trial, written_ns, &Trial::has_verdict, verdicts_);
}

void ResultLatency::note_estimate(std::span<const Id> trials, std::uint64_t written_ns) {
  for (const Id& trial : trials) note(trial, written_ns, &Trial::has_estimate, estimates_);
}

}  // namespace tonus::dashboard
