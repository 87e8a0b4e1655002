#include "services/scheduler/lease_sender.hpp"

#include <gtest/gtest.h>

#include "idl/topics.hpp"
#include "services/bus/memory/memory_fabric.hpp"
#include "services/bus/typed.hpp"
#include "services/runtime/drain.hpp"

namespace tonus::scheduler {
namespace {

TEST(LeaseSender, WithoutAThreadGivesALeaseInItsStepAndNoneOfASchedulerThatStandsStill) {
  bus::BusOptions options;
  options.vendor = bus::Vendor::kMemory;
  options.fabric = std::make_shared<bus::MemoryFabric>();
  auto bus = std::move(*bus::create_bus(options));
  auto leases = *bus::TypedReader<v1::RigLease>::create(*bus, topics::kRigLease, nullptr);
  ManualClock clock;
  auto sender = std::move(
      *LeaseSender::create(std::move(*bus::create_bus(options)), clock, LeaseSender::Works::kByStep));
  EXPECT_EQ(sender->step(), clock.now() + std::chrono::milliseconds(100));
  EXPECT_TRUE(runtime::drain(leases).empty());

  sender->set(v1::RigLease{});
  (void)sender->step();
  const auto given = runtime::drain(leases);
  ASSERT_EQ(given.size(), 1U);
  EXPECT_EQ(given[0].value.number(), 1U);

  clock.advance(LeaseSender::kLongestSilence + std::chrono::milliseconds(1));
  (void)sender->step();
  EXPECT_TRUE(runtime::drain(leases).empty());
}

}  // namespace
}  // namespace tonus::scheduler
