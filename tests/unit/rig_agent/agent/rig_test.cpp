#include "rig_agent/agent/rig.hpp"

#include <gtest/gtest.h>

namespace tonus::rig {
namespace {

std::string refusal(const RigOptions& options) {
  const auto rig = Rig::create(options, "rig");
  return rig ? "accepted" : rig.error().message;
}

TEST(Rig, OpensADriverOutOfASharedLibrary) {
  RigOptions options;
  options.driver = "library";
  options.driver_file = TONUS_SPRING_RIG;
  options.driver_options = "stiffness=200";
  options.speed = "max";
  const auto rig = Rig::create(options, "rig");
  ASSERT_TRUE(rig) << rig.error().message;
  EXPECT_EQ(rig->names().driver, "library");
  EXPECT_EQ(rig->names().loop_rate, 1000.0);
}

TEST(Rig, NamesTheFileThatADriverMisses) {
  RigOptions options;
  options.driver = "library";
  EXPECT_EQ(refusal(options), "--driver library: --driver-file is missing; expected a shared library");
  options.driver_file = "/nowhere.so";
  EXPECT_EQ(refusal(options), "driver /nowhere.so: there is no such file");
  options.driver = "replay";
  EXPECT_EQ(refusal(options), "--driver replay: --dataset is missing; expected a BIDS dataset");
}

TEST(RigOptions, AskForARealtimeLoopUnlessToldOtherwise) {
  RigOptions options;
  EXPECT_EQ(options.realtime().fifo_priority, 80);
  EXPECT_FALSE(options.realtime().cpu);
  options.fifo_priority = 0;
  options.loop_cpu = 1;
  EXPECT_FALSE(options.realtime().fifo_priority);
  EXPECT_EQ(options.realtime().cpu, 1);
}

}  // namespace
}  // namespace tonus::rig
