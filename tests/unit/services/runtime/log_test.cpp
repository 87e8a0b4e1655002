#include "services/runtime/log.hpp"

#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <regex>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include "services/runtime/options.hpp"

namespace tonus::runtime {
namespace {

CommonOptions options_with(const std::string& level) {
  CommonOptions options;
  options.log_level = level;
  return options;
}

TEST(Log, LinesCarryDateZoneLevelAndProgram) {
  ::testing::internal::CaptureStderr();
  start_log("tonus-archive", options_with("info"));
  spdlog::warn("disk is nearly full");
  spdlog::debug("not at this level");
  spdlog::default_logger()->flush();
  const std::string text = ::testing::internal::GetCapturedStderr();
  EXPECT_TRUE(std::regex_match(text, std::regex("\\d{4}-\\d\\d-\\d\\d \\d\\d:\\d\\d:\\d\\d\\.\\d{3} "
                                                "[+-]\\d\\d:\\d\\d warning tonus-archive: disk is "
                                                "nearly full\n")))
      << text;
}

TEST(Log, ASignalChangesTheLevelAndAnotherSetsItBack) {
  start_log("tonus-archive", options_with("warn"));
  raise(SIGRTMIN + 22);
  EXPECT_EQ(spdlog::default_logger()->level(), spdlog::level::debug);
  raise(SIGRTMIN + 23);
  EXPECT_EQ(spdlog::default_logger()->level(), spdlog::level::warn);
}

TEST(Log, TheJournalIsKnownByDeviceAndInodeOfStandardError) {
  struct stat status {};
  ASSERT_EQ(fstat(STDERR_FILENO, &status), 0);
  unsetenv("JOURNAL_STREAM");
  EXPECT_FALSE(is_logged_by_journal());
  setenv("JOURNAL_STREAM", (std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino)).c_str(), 1);
  EXPECT_TRUE(is_logged_by_journal());
  // Of a parent whose standard error it was, not this program's.
  setenv("JOURNAL_STREAM", (std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino + 1)).c_str(),
         1);
  EXPECT_FALSE(is_logged_by_journal());
  unsetenv("JOURNAL_STREAM");
}

}  // namespace
}  // namespace tonus::runtime
