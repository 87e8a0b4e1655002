#include "rig_agent/control/pacer.hpp"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <limits>
#include <time.h>

namespace tonus::control {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000;

}  // namespace

std::int64_t MonotonicClock::now_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * kNsPerS + now.tv_nsec;
}

void MonotonicClock::sleep_until_ns(std::int64_t wake_ns) noexcept {
  timespec wake{};
  wake.tv_sec = static_cast<time_t>(wake_ns / kNsPerS);
  wake.tv_nsec = static_cast<long>(wake_ns % kNsPerS);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr) == EINTR) {
  }
}

void JitterHistogram::add(std::int64_t lateness_ns) noexcept {
  const auto us = static_cast<std::uint64_t>(std::max<std::int64_t>(lateness_ns, 0) / 1000);
  const std::size_t i = std::min<std::size_t>(static_cast<std::size_t>(std::bit_width(us)), kClasses - 1);
  counts_[i].fetch_add(1, std::memory_order_relaxed);
  if (lateness_ns > worst_ns()) worst_ns_.store(lateness_ns, std::memory_order_relaxed);
}

std::int64_t JitterHistogram::upper_edge_us(std::size_t i) noexcept {
  return i + 1 < kClasses ? std::int64_t{1} << i : std::numeric_limits<std::int64_t>::max();
}

CycleStart Pacer::wait() noexcept {
  CycleStart start;
  std::int64_t now = clock_.now_ns();
  if (now < due_ns_) {
    clock_.sleep_until_ns(due_ns_);
    now = clock_.now_ns();
  }
  const std::int64_t late = std::max<std::int64_t>(now - due_ns_, 0);
  const std::int64_t missed = late / period_ns_;
  start.now_ns = now;
  start.lateness_ns = late;
  start.missed_periods =
      static_cast<unsigned>(std::min<std::int64_t>(missed, std::numeric_limits<unsigned>::max()));
  due_ns_ += (missed + 1) * period_ns_;

  jitter_.add(late);
  cycles_.fetch_add(1, std::memory_order_relaxed);  // Counts order nothing.
  if (missed > 0) {
    overruns_.fetch_add(1, std::memory_order_relaxed);
    missed_.fetch_add(static_cast<std::uint64_t>(missed), std::memory_order_relaxed);
  }
  return start;
}

}  // namespace tonus::control
