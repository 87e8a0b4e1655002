#include "services/runtime/rigs.hpp"

#include <CLI/CLI.hpp>
#include <gtest/gtest.h>

#include "tests/support/process.hpp"

namespace tonus::runtime {
namespace {

Result<std::vector<CommonOptions>> rigs_of(const std::string& line) {
  CLI::App app;
  CommonOptions common;
  common.rig = "bench";
  common.domain = 9;
  std::vector<std::string> names;
  add_rigs_option(app, names);
  app.parse(line);
  return each_rig(common, names);
}

TEST(Rigs, AreTheOneOfTheCommonOptionUnlessSeveralAreNamed) {
  const auto one = rigs_of("");
  ASSERT_TRUE(one);
  ASSERT_EQ(one->size(), 1U);
  EXPECT_EQ(one->front().rig, "bench");
  EXPECT_EQ(rigs_text(*one), "");
  const auto two = rigs_of("--rigs left,right");
  ASSERT_TRUE(two);
  ASSERT_EQ(two->size(), 2U);
  EXPECT_EQ(two->at(0).rig, "left");
  EXPECT_EQ(two->at(1).rig, "right");
  EXPECT_EQ(two->at(1).domain, 9);
  EXPECT_EQ(rigs_text(*two), "left, right");
}

TEST(Rigs, AreCountedWhereTheirNamesAreMany) {
  const auto rigs = rigs_of("--rigs a,b,c,d,e,f,g,h,i");
  ASSERT_TRUE(rigs);
  EXPECT_EQ(rigs_text(*rigs), "9 rigs");
}

TEST(Rigs, AreRefusedTwiceOrTooManyOrByABadName) {
  EXPECT_EQ(rigs_of("--rigs left,right,left").error().message,
            "--rigs: 'left' twice is not allowed; expected each rig once");
  std::string many = "--rigs r0";
  for (std::size_t i = 1; i <= kMostRigs; ++i) many += ",r" + std::to_string(i);
  EXPECT_EQ(rigs_of(many).error().message, "--rigs: 65 names are not allowed; expected at most 64");
  EXPECT_THROW((void)rigs_of("--rigs left,../right"), CLI::ValidationError);
}

TEST(Rigs, ShareOneParticipantWithABusForEach) {
  const auto rigs = rigs_of("--rigs left,right");
  ASSERT_TRUE(rigs);
  for (const char* dds : {"fastdds", "cyclonedds"}) {
    auto options = *rigs;
    for (auto& each : options) {
      each.dds = dds;
      each.domain = testing::own_domain();
    }
    const auto buses = open_buses(options, "tonus-identification");
    ASSERT_TRUE(buses) << buses.error().message;
    EXPECT_EQ(buses->size(), 2U);
  }
}

}  // namespace
}  // namespace tonus::runtime
