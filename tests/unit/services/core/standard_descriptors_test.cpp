#include "services/core/standard_descriptors.hpp"

#include <cstdio>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/temporary_folder.hpp"

namespace tonus {
namespace {

TEST(StandardDescriptors, AreNotGivenToDataFilesWhicheverOfThemAreClosed) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "data";
  for (int closed = 0; closed < 8; ++closed) {
    const pid_t child = ::fork();
    if (child == 0) {
      for (int descriptor = 0; descriptor < 3; ++descriptor) {
        if ((closed >> descriptor & 1) != 0) ::close(descriptor);
      }
      occupy_standard_descriptors();
      const int data = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
      bool is_good = data > STDERR_FILENO;
      for (int descriptor = 0; descriptor < 3; ++descriptor) is_good &= ::fcntl(descriptor, F_GETFD) >= 0;
      ::_exit(is_good ? 0 : 1);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_EQ(status, 0) << "closed: " << closed;
  }
}

TEST(StandardOutput, IsFinishedWithAnErrorOnAFullDisk) {
  for (const bool is_early : {false, true}) {
    const pid_t child = ::fork();
    if (child == 0) {
      const int full = ::open("/dev/full", O_WRONLY | O_CLOEXEC);
      if (full < 0 || ::dup2(full, STDOUT_FILENO) < 0) ::_exit(2);
      std::fputs("a line\n", stdout);
      if (is_early) std::fflush(stdout);
      ::_exit(finish_standard_output() ? 1 : 0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_EQ(status, 0) << "failed " << (is_early ? "before" : "at") << " the end";
  }
  EXPECT_TRUE(finish_standard_output());
}

}  // namespace
}  // namespace tonus
