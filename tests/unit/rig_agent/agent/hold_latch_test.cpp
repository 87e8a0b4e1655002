#include "rig_agent/agent/hold_latch.hpp"

#include <fcntl.h>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <unistd.h>

#include "tests/support/temporary_folder.hpp"

namespace tonus::rig {
namespace {

class HoldLatchTest : public ::testing::Test {
 protected:
  HoldLatch open() { return std::move(*HoldLatch::open(path_)); }

  testing::TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_ / "hold";
};

TEST_F(HoldLatchTest, OfANewRigIsFree) {
  EXPECT_FALSE(open().is_held());
  EXPECT_FALSE(open().is_held()) << "also when it is opened again";
}

TEST_F(HoldLatchTest, KeepsAHoldAcrossRestartsUntilItIsClearedByItsNumber) {
  ASSERT_TRUE(open().hold("fault: force"));
  HoldLatch latch = open();
  ASSERT_TRUE(latch.is_held());
  EXPECT_EQ(latch.because(), "fault: force");
  EXPECT_EQ(latch.number(), 1u);
  EXPECT_FALSE(latch.clear(2));
  EXPECT_TRUE(open().is_held());
  ASSERT_TRUE(latch.clear(1));
  EXPECT_FALSE(open().is_held());
  ASSERT_TRUE(latch.hold("stop by somebody"));
  EXPECT_EQ(open().number(), 2u) << "a clear that is late does not end a later hold";
}

TEST_F(HoldLatchTest, AddsASecondReasonToTheFirst) {
  HoldLatch latch = open();
  ASSERT_TRUE(latch.hold("fault: force"));
  ASSERT_TRUE(latch.hold("stop by somebody"));
  ASSERT_TRUE(latch.hold("fault: force"));
  EXPECT_EQ(open().because(), "fault: force; stop by somebody");
  EXPECT_EQ(open().number(), 1u);
}

TEST_F(HoldLatchTest, NeedsAnOperatorOnceOneReasonDoes) {
  HoldLatch latch = open();
  ASSERT_TRUE(latch.hold("fault: force", false));
  EXPECT_FALSE(open().needs_operator());
  ASSERT_TRUE(latch.hold("stop by somebody"));
  ASSERT_TRUE(latch.hold("fault: force", false));
  EXPECT_TRUE(open().needs_operator()) << "also after a restart";
  ASSERT_TRUE(latch.clear(1));
  ASSERT_TRUE(latch.hold("fault: force", false));
  EXPECT_FALSE(open().needs_operator()) << "a later hold has reasons of its own";
}

TEST_F(HoldLatchTest, WritesAReasonThatIsKnownOnce) {
  const auto content = [this] {
    std::ifstream file(path_, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  HoldLatch latch = open();
  ASSERT_TRUE(latch.hold("fault: force"));
  const std::string before = content();
  ASSERT_TRUE(latch.hold("fault: force"));
  EXPECT_EQ(content(), before);
}

TEST_F(HoldLatchTest, HoldsARigWhoseAgentEndedUnderPower) {
  ASSERT_TRUE(open().set_powered(true));
  EXPECT_EQ(open().because(), "the rig agent ended while the rig was under power");
  HoldLatch latch = open();
  ASSERT_TRUE(latch.clear(latch.number()));
  ASSERT_TRUE(latch.set_powered(true));
  ASSERT_TRUE(latch.set_powered(false));
  EXPECT_FALSE(open().is_held()) << "an agent that ended in order";
}

TEST_F(HoldLatchTest, GoesBackToTheStateBeforeAWriteThatWasTorn) {
  {
    HoldLatch latch = open();
    ASSERT_TRUE(latch.hold("fault: force"));
    ASSERT_TRUE(latch.clear(1));
  }
  // Whichever slot is newest: with one damaged the other one speaks.
  int held = 0;
  for (const off_t slot : {off_t{0}, off_t{4096}}) {
    const auto copy = folder_ / "copy";
    std::filesystem::copy_file(path_, copy, std::filesystem::copy_options::overwrite_existing);
    const int file = ::open(copy.c_str(), O_WRONLY);
    ASSERT_EQ(::pwrite(file, "torn", 4, slot + 20), 4);
    ::close(file);
    held += HoldLatch::open(copy)->is_held() ? 1 : 0;
  }
  EXPECT_EQ(held, 1);
}

TEST_F(HoldLatchTest, HoldsARigWhoseFileCannotBeRead) {
  std::ofstream(path_) << "something else";
  HoldLatch latch = open();
  EXPECT_TRUE(latch.is_held());
  EXPECT_NE(latch.because().find("cannot be read"), std::string::npos);
  EXPECT_TRUE(latch.needs_operator());
  ASSERT_TRUE(latch.clear(latch.number()));
  EXPECT_FALSE(open().is_held());
}

TEST_F(HoldLatchTest, NeedsNoRoomOnTheDiskToHold) {
  (void)open();
  const auto size = std::filesystem::file_size(path_);
  HoldLatch latch = open();
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(latch.hold("reason " + std::to_string(i)));
  EXPECT_EQ(std::filesystem::file_size(path_), size);
}

TEST_F(HoldLatchTest, CutsAReasonThatIsLongerThanItsSlot) {
  ASSERT_TRUE(open().hold(std::string(10000, 'x')));
  EXPECT_EQ(open().because(), std::string(447, 'x'));
}

}  // namespace
}  // namespace tonus::rig
