#include "services/archive/gap_watch.hpp"

#include <gtest/gtest.h>

namespace tonus::archive {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

using Ranges = std::vector<store::SequenceRange>;

class GapWatchTest : public ::testing::Test {
 protected:
  Ranges ask(const Ranges& missing) { return watch_.ask(missing, clock_.now()); }

  ManualClock clock_;
  GapWatch watch_{{milliseconds(100), seconds(1), 1000}};
};

TEST_F(GapWatchTest, LeavesAGapTimeToCloseByItself) {
  EXPECT_EQ(ask({{10, 20}}), Ranges{});
  EXPECT_EQ(watch_.due(), clock_.now() + milliseconds(100));
  clock_.advance(milliseconds(99));
  EXPECT_EQ(ask({{10, 20}}), Ranges{});
  clock_.advance(milliseconds(1));
  EXPECT_EQ(ask({{10, 20}}), (Ranges{{10, 20}}));
}

TEST_F(GapWatchTest, DoesNotAskWhileTheEndOfALiveStreamMovesOn) {
  for (std::uint64_t i = 0; i < 50; ++i) {
    EXPECT_EQ(ask({{i * 20, i * 20 + 40}}), Ranges{});
    clock_.advance(milliseconds(50));
  }
}

TEST_F(GapWatchTest, AsksAgainEverMoreRarely) {
  std::vector<int> asked_after_ms;
  for (int ms = 0; ms <= 4000; ms += 50) {
    if (!ask({{10, 20}}).empty()) asked_after_ms.push_back(ms);
    clock_.advance(milliseconds(50));
  }
  EXPECT_EQ(asked_after_ms, (std::vector<int>{100, 200, 400, 800, 1600, 2600, 3600}));
}

TEST_F(GapWatchTest, AsksForALongGapInPieces) {
  ask({{0, 2500}});
  clock_.advance(milliseconds(100));
  EXPECT_EQ(ask({{0, 2500}}), (Ranges{{0, 1000}}));
  EXPECT_EQ(ask({{400, 2500}}), Ranges{});                 // the piece is being served
  EXPECT_EQ(ask({{1000, 2500}}), (Ranges{{1000, 2000}}));  // and is: the next one at once
  EXPECT_EQ(ask({{2000, 2500}}), (Ranges{{2000, 2500}}));
}

TEST_F(GapWatchTest, GivesEachGapItsOwnTime) {
  ask({{10, 20}});
  clock_.advance(milliseconds(60));
  ask({{10, 20}, {50, 60}});
  clock_.advance(milliseconds(40));
  EXPECT_EQ(ask({{10, 20}, {50, 60}}), (Ranges{{10, 20}}));
  clock_.advance(milliseconds(60));
  EXPECT_EQ(ask({{10, 20}, {50, 60}}), (Ranges{{50, 60}}));
}

TEST_F(GapWatchTest, ForgetsWhatIsThere) {
  ask({{10, 20}});
  EXPECT_EQ(ask({}), Ranges{});
  EXPECT_EQ(watch_.due(), Clock::TimePoint::max());
}

}  // namespace
}  // namespace tonus::archive
