#include "services/core/standard_descriptors.hpp"

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

}  // namespace
}  // namespace tonus
