#include "services/core/machine_lock.hpp"

#include <gtest/gtest.h>
#include <optional>
#include <sys/wait.h>
#include <unistd.h>

namespace tonus {
namespace {

std::string own_name() { return "test " + std::to_string(getpid()); }

TEST(MachineLockTest, IsTakenOnceAndNamesItsHolder) {
  auto first = MachineLock::take(own_name());
  ASSERT_TRUE(first) << first.error().message;
  const auto second = MachineLock::take(own_name());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kAlreadyExists);
  EXPECT_EQ(second.error().message, own_name() + " is in use by process " + std::to_string(getpid()));
}

TEST(MachineLockTest, IsGivenUpWithItsHolder) {
  const std::string name = own_name();
  const pid_t child = fork();
  if (child == 0) _exit(MachineLock::take(name) ? 0 : 1);
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(MachineLock::take(name));
  EXPECT_TRUE(MachineLock::take(name)) << "the one before is gone";
}

TEST(MachineLockTest, RefusesANameThatIsTooLong) { EXPECT_FALSE(MachineLock::take(std::string(200, 'x'))); }

}  // namespace
}  // namespace tonus
