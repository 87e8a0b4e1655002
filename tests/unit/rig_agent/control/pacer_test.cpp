#include "rig_agent/control/pacer.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <vector>

namespace tonus::control {
namespace {

constexpr std::int64_t kPeriod = 1'000'000;

// A clock moved by hand: a sleep ends `oversleep` late.
class ManualClock final : public PacerClock {
 public:
  std::int64_t now_ns() noexcept override { return now; }
  void sleep_until_ns(std::int64_t wake_ns) noexcept override { now = wake_ns + oversleep; }

  std::int64_t now = 5'000'000'000;
  std::int64_t oversleep = 0;
};

TEST(Pacer, StartsCyclesOnAnAbsoluteGridWhateverTheWorkTakes) {
  ManualClock clock;
  Pacer pacer(clock, kPeriod);
  const std::int64_t start = clock.now;
  pacer.start();
  for (std::int64_t k = 1; k <= 5; ++k) {
    const CycleStart cycle = pacer.wait();
    EXPECT_EQ(cycle.now_ns, start + k * kPeriod);
    EXPECT_EQ(cycle.lateness_ns, 0);
    EXPECT_EQ(cycle.missed_periods, 0U);
    clock.now += 100'000 * k;  // Work of different length, each within the period.
  }
  EXPECT_EQ(pacer.cycles(), 5U);
  EXPECT_EQ(pacer.overruns(), 0U);
}

TEST(Pacer, DoesNotLetALateWakingShiftTheCyclesAfterIt) {
  ManualClock clock;
  Pacer pacer(clock, kPeriod);
  const std::int64_t start = clock.now;
  pacer.start();
  clock.oversleep = 300'000;
  EXPECT_EQ(pacer.wait().lateness_ns, 300'000);
  clock.oversleep = 0;
  EXPECT_EQ(pacer.wait().now_ns, start + 2 * kPeriod);
}

TEST(Pacer, CountsPeriodsMissedByLongWorkAndKeepsTheGrid) {
  ManualClock clock;
  Pacer pacer(clock, kPeriod);
  const std::int64_t start = clock.now;
  pacer.start();
  pacer.wait();            // At start + 1 period.
  clock.now += 3'400'000;  // Work until start + 4.4 periods: those due at 2 and 3 are missed, 4 is late.
  const CycleStart late = pacer.wait();
  EXPECT_EQ(late.missed_periods, 2U);
  EXPECT_EQ(late.now_ns, start + 4'400'000);
  EXPECT_EQ(pacer.wait().now_ns, start + 5 * kPeriod);
  EXPECT_EQ(pacer.overruns(), 1U);
  EXPECT_EQ(pacer.missed_periods(), 2U);
}

TEST(Pacer, StartsAtOnceWhenTheCycleIsLateByLessThanAPeriod) {
  ManualClock clock;
  Pacer pacer(clock, kPeriod);
  const std::int64_t start = clock.now;
  pacer.start();
  pacer.wait();
  clock.now += 1'500'000;
  const CycleStart late = pacer.wait();
  EXPECT_EQ(late.now_ns, start + 2'500'000);
  EXPECT_EQ(late.missed_periods, 0U);
  EXPECT_EQ(late.lateness_ns, 500'000);
}

TEST(JitterHistogram, SortsLatenessIntoDoublingClasses) {
  JitterHistogram jitter;
  jitter.add(0);
  jitter.add(999);
  jitter.add(1'000);
  jitter.add(3'999);
  jitter.add(4'000);
  jitter.add(60'000'000'000);
  EXPECT_EQ(jitter.count(0), 2U);  // Under 1 us.
  EXPECT_EQ(jitter.count(1), 1U);  // 1 us to 2 us.
  EXPECT_EQ(jitter.count(2), 1U);  // 2 us to 4 us.
  EXPECT_EQ(jitter.count(3), 1U);  // 4 us to 8 us.
  EXPECT_EQ(jitter.count(JitterHistogram::kClasses - 1), 1U);
  EXPECT_EQ(jitter.worst_ns(), 60'000'000'000);
  EXPECT_EQ(JitterHistogram::upper_edge_us(2), 4);
  EXPECT_EQ(JitterHistogram::upper_edge_us(JitterHistogram::kClasses - 1),
            std::numeric_limits<std::int64_t>::max());
}

TEST(MonotonicClock, NeverWakesBeforeTheTimeItWasGiven) {
  MonotonicClock clock;
  const std::int64_t wake = clock.now_ns() + 2'000'000;
  clock.sleep_until_ns(wake);
  EXPECT_GE(clock.now_ns(), wake);
}

}  // namespace
}  // namespace tonus::control
