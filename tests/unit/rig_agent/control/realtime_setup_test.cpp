#include "rig_agent/control/realtime_setup.hpp"

#include <gmock/gmock.h>
#include <pthread.h>
#include <sched.h>
#include <thread>

namespace tonus::control {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// Scheduling belongs to the calling thread: each request is made on a thread of its own.
RealtimeGrant granted(const RealtimeRequest& request) {
  RealtimeGrant grant;
  std::thread([&] { grant = set_up_realtime(request); }).join();
  return grant;
}

TEST(RealtimeSetup, SaysThatNothingWasAskedFor) {
  const RealtimeGrant grant = granted({std::nullopt, std::nullopt, false});
  EXPECT_EQ(grant.statement, "realtime: nothing was asked for");
  EXPECT_TRUE(grant.is_complete);
}

TEST(RealtimeSetup, RefusesAPriorityThatDoesNotExistWithItsReason) {
  const RealtimeGrant grant = granted({1000, std::nullopt, false});
  EXPECT_FALSE(grant.has_fifo);
  EXPECT_FALSE(grant.is_complete);
  EXPECT_THAT(grant.statement, StartsWith("realtime: SCHED_FIFO 1000 refused (Invalid argument"));
}

TEST(RealtimeSetup, RefusesAProcessorThatDoesNotExist) {
  const RealtimeGrant grant = granted({std::nullopt, 100'000, false});
  EXPECT_FALSE(grant.has_cpu);
  EXPECT_THAT(grant.statement, HasSubstr("processor 100000 refused"));
}

TEST(RealtimeSetup, GivesTheFirstProcessorOfTheProcess) {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  ASSERT_EQ(sched_getaffinity(0, sizeof(allowed), &allowed), 0);
  int cpu = 0;
  while (!CPU_ISSET(static_cast<std::size_t>(cpu), &allowed)) ++cpu;
  const RealtimeGrant grant = granted({std::nullopt, cpu, false});
  EXPECT_TRUE(grant.has_cpu);
  EXPECT_TRUE(grant.is_complete);
  EXPECT_EQ(grant.statement, "realtime: processor " + std::to_string(cpu));
}

TEST(RealtimeSetup, GivesThreadsThatBeginLaterASmallStack) {
  keep_stacks_small();
  std::size_t bytes = 0;
  std::thread([&bytes] {
    pthread_attr_t own;
    ASSERT_EQ(pthread_getattr_np(pthread_self(), &own), 0);
    EXPECT_EQ(pthread_attr_getstacksize(&own, &bytes), 0);
    EXPECT_EQ(pthread_attr_destroy(&own), 0);
  }).join();
  EXPECT_EQ(bytes, kSmallStack);
}

}  // namespace
}  // namespace tonus::control
