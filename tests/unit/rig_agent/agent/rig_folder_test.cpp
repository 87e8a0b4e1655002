#include "rig_agent/agent/rig_folder.hpp"

#include <fstream>
#include <gtest/gtest.h>

#include "rig_agent/agent/rig.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::rig {
namespace {

class RigFolderTest : public ::testing::Test {
 protected:
  const ::tonus::testing::TemporaryFolder folder_;
  const std::filesystem::path own_ = folder_ / "rigs" / "left";
};

TEST_F(RigFolderTest, KeepsCalibrationAndHoldWhateverTheDataFolder) {
  std::filesystem::path hold;
  std::filesystem::path calibration;
  for (const char* data : {"monday", "tuesday"}) {
    const auto folder = RigFolder::take(folder_ / data, "left", own_);
    ASSERT_TRUE(folder) << folder.error().message;
    EXPECT_TRUE(hold.empty() || hold == folder->hold());
    EXPECT_TRUE(calibration.empty() || calibration == folder->calibration());
    hold = folder->hold();
    calibration = folder->calibration();
    EXPECT_EQ(folder->trial_log(), folder_ / data / "rig/left/trials.log");
  }
  EXPECT_EQ(hold, own_ / "hold");
}

TEST_F(RigFolderTest, IsOneProgramsWithWhateverDataFolder) {
  const auto first = RigFolder::take(folder_ / "monday", "left", own_);
  ASSERT_TRUE(first);
  const auto second = RigFolder::take(folder_ / "tuesday", "left", own_);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(second.error().message.find("'left' is in use"), std::string::npos) << second.error().message;
}

TEST_F(RigFolderTest, DoesNotForgetAHoldThatAnEarlierVersionKeptInTheDataFolder) {
  for (const char* file : {"hold", "calibration.toml"}) {
    const auto before = folder_ / file / "rig" / "left";
    std::filesystem::create_directories(before);
    std::ofstream(before / file) << "kept";
    const auto refused = RigFolder::take(folder_ / file, "left", own_);
    ASSERT_FALSE(refused);
    for (const auto& path : {before / file, own_ / file})
      EXPECT_NE(refused.error().message.find(path.string()), std::string::npos) << refused.error().message;
    std::filesystem::rename(before / file, own_ / file);
    EXPECT_TRUE(RigFolder::take(folder_ / file, "left", own_));
  }
}

TEST_F(RigFolderTest, IsTheDataFoldersWhereNothingRealMoves) {
  RigOptions options;
  for (const char* driver : {"simulated", "replay"}) {
    options.driver = driver;
    EXPECT_EQ(*options.own_folder("left"), "") << driver;
  }
  for (const char* driver : {"library", "comedi"}) {
    options.driver = driver;
    const auto place = options.own_folder("left");
    EXPECT_TRUE(!place || place->is_absolute()) << driver;
    options.folder = own_.string();
    EXPECT_EQ(*options.own_folder("left"), own_) << driver;
    options.folder.clear();
  }
}

}  // namespace
}  // namespace tonus::rig
