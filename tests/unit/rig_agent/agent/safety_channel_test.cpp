#include "rig_agent/agent/safety_channel.hpp"

#include <gtest/gtest.h>

#include "idl/topics.hpp"
#include "services/bus/memory/memory_fabric.hpp"
#include "services/bus/typed.hpp"
#include "services/runtime/rig_stop.hpp"
#include "tests/support/simulated_rig.hpp"

namespace tonus::rig {
namespace {

const Id kRig = id_of("rig/rig");

class SafetyChannelTest : public ::testing::Test {
 protected:
  std::unique_ptr<bus::Bus> open_bus() {
    bus::BusOptions options;
    options.vendor = bus::Vendor::kMemory;
    options.fabric = fabric_;
    return std::move(*bus::create_bus(options));
  }
  bool is_stopped() {
    return (rig_.loop().state().faults & control::bit(control::Fault::kEmergencyStop)) != 0;
  }

  SystemClock clock_;
  std::shared_ptr<bus::MemoryFabric> fabric_ = std::make_shared<bus::MemoryFabric>();
  SimulatedRig rig_;
  Lease lease_{kRig, 1};
  StopRequests stops_;
  std::shared_ptr<bus::Notifier> wake_ = std::make_shared<bus::Notifier>();
  std::unique_ptr<SafetyChannel> channel_ =
      std::move(*SafetyChannel::create(open_bus(), kRig, rig_.loop(), lease_, stops_, clock_, wake_));
};

TEST_F(SafetyChannelTest, AStopStopsTheLoopAndIsConfirmedWhenTheLoopShowsIt) {
  auto sender = *runtime::RigStopSender::create(open_bus(), clock_);
  std::atomic<bool> is_over{false};
  std::thread loop([&] {
    while (!is_over) rig_.step_silently();
  });
  const auto took = sender.stop(kRig, random_id(), "a test", std::chrono::seconds(30));
  is_over = true;
  loop.join();
  EXPECT_TRUE(took) << took.error().message;
  EXPECT_TRUE(is_stopped());
  EXPECT_EQ(stops_.take(), "a test");
}

TEST_F(SafetyChannelTest, AStopOfAnotherRigIsNotItsOwn) {
  auto sender = *runtime::RigStopSender::create(open_bus(), clock_);
  const auto took = sender.stop(id_of("rig/other"), random_id(), "a test", std::chrono::milliseconds(50));
  EXPECT_FALSE(took);
  rig_.step_silently();
  EXPECT_FALSE(is_stopped());
}

TEST_F(SafetyChannelTest, ALateRepeatOfAStopThatWasConfirmedStopsNothingAnew) {
  auto bus = open_bus();
  auto writer = *bus::TypedWriter<v1::RigStop>::create(*bus, topics::kRigStop);
  auto notifier = std::make_shared<bus::Notifier>();
  auto stopped = *bus::TypedReader<v1::RigStop>::create(*bus, topics::kRigStopped, notifier);
  v1::RigStop stop;
  stop.rig_id(kRig);
  stop.stop_id(random_id());
  const auto confirmed = [&] {
    ASSERT_TRUE(writer.write(stop));
    const auto deadline = clock_.now() + std::chrono::seconds(30);
    std::vector<bus::Received<v1::RigStop>> answers;
    while (answers.empty() && clock_.now() < deadline) {
      rig_.step();
      (void)notifier->wait_until(clock_.now() + std::chrono::milliseconds(1));
      stopped.take(answers);
    }
    EXPECT_FALSE(answers.empty());
  };
  confirmed();
  EXPECT_TRUE(is_stopped());
  ASSERT_TRUE(rig_.step_until(
      [&] { return rig_.ask(control::CommandKind::kClearFaults).result == control::CommandResult::kDone; }));
  confirmed();
  EXPECT_FALSE(is_stopped());
}

TEST_F(SafetyChannelTest, WithoutAThreadAStopAndALeaseTakeEffectInItsStep) {
  const auto stepped = std::move(*SafetyChannel::create(open_bus(), kRig, rig_.loop(), lease_, stops_, clock_,
                                                        wake_, SafetyChannel::Works::kByStep));
  channel_.reset();  // the one with a thread
  auto bus = open_bus();
  auto stops = *bus::TypedWriter<v1::RigStop>::create(*bus, topics::kRigStop);
  v1::RigStop stop;
  stop.rig_id(kRig);
  stop.stop_id(random_id());
  stop.requested_by("a test");
  ASSERT_TRUE(stops.write(stop));
  rig_.step_silently();
  EXPECT_FALSE(is_stopped());
  EXPECT_GT(stepped->step(), clock_.now() - std::chrono::seconds(1));
  rig_.step_silently();
  EXPECT_TRUE(is_stopped());
  EXPECT_EQ(stops_.take(), "a test");
}

}  // namespace
}  // namespace tonus::rig
