#include "rig_agent/agent/loop_report.hpp"

#include <gtest/gtest.h>
#include <numeric>

#include "idl/bounds.hpp"
#include "idl/topics.hpp"
#include "services/bus/memory/memory_fabric.hpp"
#include "services/runtime/drain.hpp"
#include "tests/support/simulated_rig.hpp"

namespace tonus::rig {
namespace {

const Id kRig = id_of("rig/rig");

/// A pacer's clock that oversleeps as a test says.
class OversleepingClock final : public control::PacerClock {
 public:
  std::int64_t now_ns() noexcept override { return now_; }
  void sleep_until_ns(std::int64_t wake) noexcept override { now_ = wake + oversleep; }
  std::int64_t oversleep = 0;

 private:
  std::int64_t now_ = 0;
};

class LoopReportTest : public ::testing::Test {
 protected:
  void SetUp() override {
    bus::BusOptions options;
    options.vendor = bus::Vendor::kMemory;
    options.fabric = std::make_shared<bus::MemoryFabric>();
    bus_ = std::move(*bus::create_bus(options));
    timing_.emplace(*bus::TypedReader<v1::RigTiming>::create(*bus_, topics::kRigTiming, nullptr));
    records_.emplace(*bus::TypedReader<v1::FlightRecord>::create(*bus_, topics::kRigFlightRecord, nullptr));
    pacer_.start();
    auto report =
        LoopReport::create(*bus_, {kRig, 77, "realtime: as asked for", &pacer_}, rig_.loop(), clock_);
    ASSERT_TRUE(report) << report.error().message;
    report_.emplace(std::move(*report));
  }

  std::vector<v1::FlightRecord> published() {
    std::vector<v1::FlightRecord> parts;
    for (auto& received : runtime::drain(*records_)) parts.push_back(std::move(received.value));
    return parts;
  }
  void fault() {
    rig_.loop().emergency_stop();
    rig_.step();
    ASSERT_NE(rig_.loop().state().faults, 0U);
  }
  void clear() {
    for (int i = 0; i < 500; ++i) rig_.step();  // To rest.
    ASSERT_EQ(rig_.ask(control::CommandKind::kClearFaults).result, control::CommandResult::kDone);
  }

  std::unique_ptr<bus::Bus> bus_;
  std::optional<bus::TypedReader<v1::RigTiming>> timing_;
  std::optional<bus::TypedReader<v1::FlightRecord>> records_;
  SimulatedRig rig_;
  OversleepingClock pacer_clock_;
  control::Pacer pacer_{pacer_clock_, 1'000'000};
  ManualClock clock_;
  std::optional<LoopReport> report_;
};

TEST_F(LoopReportTest, PublishesTheTimingOnceASecondWithItsHistogram) {
  for (int i = 0; i < 10; ++i) pacer_.wait();
  pacer_clock_.oversleep = 3'000;  // 3 us: class 2, from 2 to 4 us
  pacer_.wait();
  pacer_clock_.oversleep = 2'500'000;  // two whole periods missed
  pacer_.wait();
  report_->step();
  clock_.advance(std::chrono::milliseconds(900));
  report_->step();
  auto received = runtime::drain(*timing_);
  ASSERT_EQ(received.size(), 1U);
  const v1::RigTiming& timing = received[0].value;
  EXPECT_EQ(timing.rig_id(), kRig);
  EXPECT_EQ(timing.epoch(), 77U);
  EXPECT_EQ(timing.scheduling(), "realtime: as asked for");
  EXPECT_EQ(timing.period_s(), 0.001);
  EXPECT_EQ(timing.cycles(), 12U);
  EXPECT_EQ(timing.overruns(), 1U);
  EXPECT_EQ(timing.missed_periods(), 2U);
  EXPECT_EQ(timing.worst_lateness_ns(), 2'500'000);
  EXPECT_EQ(timing.lateness_count()[0], 10U);
  EXPECT_EQ(timing.lateness_count()[2], 1U);
  EXPECT_EQ(timing.lateness_count()[12], 1U);  // 2048 to 4096 us
  const auto& counts = timing.lateness_count();
  EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), std::uint64_t{0}), 12U);
  clock_.advance(std::chrono::milliseconds(100));
  report_->step();
  EXPECT_EQ(runtime::drain(*timing_).size(), 1U);
}

TEST_F(LoopReportTest, PublishesTheLastTwoSecondsBeforeAFaultInParts) {
  for (int i = 0; i < 3000; ++i) rig_.step();
  report_->step();
  EXPECT_TRUE(published().empty());
  fault();
  const std::uint64_t fault_cycle = rig_.loop().state().cycle - 1;
  report_->step();
  const auto parts = published();
  ASSERT_EQ(parts.size(), 8U);  // 2000 cycles, 256 in a part
  std::uint64_t next = fault_cycle - 1999;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    EXPECT_EQ(parts[i].rig_id(), kRig);
    EXPECT_EQ(parts[i].epoch(), 77U);
    EXPECT_EQ(parts[i].fault_number(), 1U);
    EXPECT_EQ(parts[i].fault(), "emergency_stop");
    EXPECT_EQ(parts[i].part(), i);
    EXPECT_EQ(parts[i].parts(), 8U);
    for (const auto& cycle : parts[i].cycles()) EXPECT_EQ(cycle.cycle(), next++);
  }
  EXPECT_EQ(next, fault_cycle + 1);
  EXPECT_EQ(parts.back().cycles().back().fault_bits(), control::bit(control::Fault::kEmergencyStop));
  EXPECT_EQ(parts.back().cycles().back().phase(), v1::PHASE_SAFE);
  EXPECT_EQ(parts.back().cycles()[200].fault_bits(), 0U);
}

TEST_F(LoopReportTest, PublishesAFaultOnceAndNumbersTheNext) {
  fault();
  report_->step();
  report_->step();
  const auto first = published();
  ASSERT_EQ(first.size(), 1U);
  clear();
  for (int i = 0; i < 300; ++i) rig_.step();
  fault();
  report_->step();
  const auto second = published();
  ASSERT_FALSE(second.empty());
  EXPECT_EQ(second[0].fault_number(), 2U);
  EXPECT_EQ(second[0].part_id(), first[0].part_id());  // takes its place
}

TEST_F(LoopReportTest, KeepsARecordThroughItsFaultsClearingUntilItIsRead) {
  for (int i = 0; i < 100; ++i) rig_.step();
  fault();
  const std::uint64_t fault_cycle = rig_.loop().state().cycle - 1;
  clear();
  for (int i = 0; i < 5000; ++i) rig_.step();
  report_->step();
  const auto parts = published();
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].cycles().back().cycle(), fault_cycle);
  rig_.step();
  EXPECT_FALSE(rig_.loop().flight_recorder().is_frozen());  // Recording goes on.
}

}  // namespace
}  // namespace tonus::rig
