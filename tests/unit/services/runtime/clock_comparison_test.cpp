#include "services/runtime/clock_comparison.hpp"

#include <gtest/gtest.h>

#include "idl/topics.hpp"
#include "services/bus/memory/memory_fabric.hpp"
#include "services/runtime/drain.hpp"

/// Two services on a bus within the process, each with a clock of its own that is advanced by hand.
namespace tonus::runtime {
namespace {

using namespace std::chrono_literals;

CommonOptions named(const std::string& name) {
  CommonOptions options;
  options.rig = name;
  return options;
}

class ClockComparisonTest : public ::testing::Test {
 protected:
  static constexpr std::chrono::nanoseconds kAhead = 7s + 123us;

  void SetUp() override {
    answerer_clock_.advance(kAhead);
    start_answerer();
    roster_.emplace(*Roster::create(*bus_, asker_clock_, nullptr));
    asker_.emplace(*HealthReporter::create(*bus_, asker_clock_, v1::ROLE_ARCHIVE, named("lab")));
    comparison_.emplace(*ClockComparison::create(*bus_, asker_clock_, asker_->instance(), nullptr,
                                                 ClockComparison::Options{}));
    offsets_.emplace(*bus::TypedReader<v1::ClockOffset>::create(*bus_, topics::kClockOffset, nullptr));
    probes_.emplace(*bus::TypedReader<v1::ClockProbe>::create(*bus_, topics::kClockProbe, nullptr));
  }

  void start_answerer() {
    answerer_.reset();
    answerer_.emplace(*HealthReporter::create(*bus_, answerer_clock_, v1::ROLE_RIG, named("lab")));
    answerer_->publish_if_due();
  }

  void pass(Clock::Duration duration) {
    asker_clock_.advance(duration);
    answerer_clock_.advance(duration);
  }

  /// One question and its answer; the message takes `there` and `back` on its ways.
  void exchange(Clock::Duration there, Clock::Duration back) {
    roster_->update();
    comparison_->step(*roster_);
    pass(there);
    answerer_->publish_if_due();
    pass(back);
    comparison_->step(*roster_);
  }

  std::size_t questions() { return drain(*probes_).size(); }

  std::unique_ptr<bus::Bus> make_bus() {
    bus::BusOptions options;
    options.vendor = bus::Vendor::kMemory;
    options.fabric = std::make_shared<bus::MemoryFabric>();
    return std::move(*bus::create_bus(options));
  }

  ManualClock asker_clock_;
  ManualClock answerer_clock_;
  std::unique_ptr<bus::Bus> bus_ = make_bus();
  std::optional<HealthReporter> answerer_;
  std::optional<HealthReporter> asker_;
  std::optional<Roster> roster_;
  std::optional<ClockComparison> comparison_;
  std::optional<bus::TypedReader<v1::ClockOffset>> offsets_;
  std::optional<bus::TypedReader<v1::ClockProbe>> probes_;
};

TEST_F(ClockComparisonTest, PublishesTheOffsetOfTheShortestRoundTripOfABurst) {
  for (int i = 0; i < 16; ++i) {
    EXPECT_TRUE(drain(*offsets_).empty());
    exchange(i == 9 ? 20us : 300us, i == 9 ? 20us : 900us);
  }
  const auto published = drain(*offsets_);
  ASSERT_EQ(published.size(), 1U);
  const v1::ClockOffset& offset = published[0].value;
  EXPECT_EQ(offset.asker_id(), asker_->instance());
  EXPECT_EQ(offset.answerer_id(), answerer_->instance());
  EXPECT_EQ(offset.offset_ns(), kAhead.count());
  EXPECT_GE(offset.uncertainty_ns(), 20'000);
  EXPECT_LE(offset.uncertainty_ns(), 21'000);  // 6 x 1.2 ms old by then, at 50 parts in a million
  EXPECT_EQ(offset.probes(), 16U);
}

TEST_F(ClockComparisonTest, AsksAgainAfterAWhile) {
  for (int i = 0; i < 16; ++i) exchange(10us, 10us);
  EXPECT_EQ(questions(), 16U);
  EXPECT_EQ(drain(*offsets_).size(), 1U);
  exchange(10us, 10us);
  EXPECT_EQ(questions(), 0U);
  pass(5s);
  answerer_->publish_if_due();
  for (int i = 0; i < 4; ++i) exchange(10us, 10us);
  EXPECT_EQ(questions(), 4U);
  EXPECT_EQ(drain(*offsets_).size(), 1U);
}

TEST_F(ClockComparisonTest, GoesOnWhereAnAnswerDoesNotCome) {
  roster_->update();
  comparison_->step(*roster_);
  EXPECT_EQ(questions(), 1U);
  comparison_->step(*roster_);
  EXPECT_EQ(questions(), 0U);
  pass(500ms);
  comparison_->step(*roster_);
  EXPECT_EQ(questions(), 1U);
  // The answer to the first question comes after all, and is of no use any more.
  pass(10us);
  answerer_->publish_if_due();
  pass(10us);
  comparison_->step(*roster_);
  for (int i = 0; i < 14; ++i) exchange(10us, 10us);
  const auto published = drain(*offsets_);
  ASSERT_EQ(published.size(), 1U);
  EXPECT_EQ(published[0].value.probes(), 15U);
  EXPECT_EQ(published[0].value.offset_ns(), kAhead.count());
}

TEST_F(ClockComparisonTest, BeginsAnewWithAServiceThatWasStartedAnew) {
  for (int i = 0; i < 16; ++i) exchange(10us, 10us);
  EXPECT_EQ(questions(), 16U);
  answerer_clock_.advance(1h);  // another host, or the same one after it was switched off
  start_answerer();
  for (int i = 0; i < 16; ++i) exchange(10us, 10us);
  EXPECT_EQ(questions(), 16U);
  EXPECT_EQ(drain(*offsets_).back().value.offset_ns(), std::chrono::nanoseconds(kAhead + 1h).count());
}

TEST_F(ClockComparisonTest, AsksNobodyWhoIsNotThereAndNotItself) {
  roster_->update();
  pass(3s);
  asker_->publish_if_due();
  roster_->update();
  ASSERT_EQ(roster_->present().size(), 1U);
  comparison_->step(*roster_);
  EXPECT_EQ(questions(), 0U);
}

}  // namespace
}  // namespace tonus::runtime
