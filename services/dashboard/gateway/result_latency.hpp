#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <span>

#include "services/core/id.hpp"

namespace tonus::dashboard {

/// How often something took how long, as Prometheus counts it.
class Histogram {
 public:
  /// Upper ends of the buckets, s; longer ones are in none of them.
  static constexpr std::array<double, 10> kEnds{0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0};

  void add(double seconds);

  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double sum() const { return sum_; }
  /// Of those that took at most kEnds[bucket].
  [[nodiscard]] std::uint64_t count_within(std::size_t bucket) const { return within_[bucket]; }

 private:
  std::array<std::uint64_t, kEnds.size()> within_{};
  std::uint64_t count_ = 0;
  double sum_ = 0.0;
};

/// From a trial's end, when the rig wrote its outcome, to its verdict and to the first estimate that counts
/// it, when identification wrote them; UTC of the writers, so clocks of two hosts are in it. Each trial
/// counts once in each. Of the last 256 outcomes; no thread.
class ResultLatency {
 public:
  void note_outcome(const Id& trial, std::uint64_t written_ns);
  void note_verdict(const Id& trial, std::uint64_t written_ns);
  void note_estimate(std::span<const Id> trials, std::uint64_t written_ns);

  [[nodiscard]] const Histogram& verdicts() const { return verdicts_; }
  [[nodiscard]] const Histogram& estimates() const { return estimates_; }

 private:
  struct Trial {
    std::uint64_t ended_ns = 0;
    bool has_verdict = false;
    bool has_estimate = false;
  };
  void note(const Id& trial, std::uint64_t written_ns, bool Trial::*has, Histogram& histogram);

  std::map<Id, Trial> trials_;
  std::deque<Id> order_;
  Histogram verdicts_;
  Histogram estimates_;
};

}  // namespace tonus::dashboard
