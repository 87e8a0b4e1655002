#include "services/core/standard_descriptors.hpp"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace tonus {

void occupy_standard_descriptors() {
  for (int descriptor = STDIN_FILENO; descriptor <= STDERR_FILENO; ++descriptor) {
    if (::fcntl(descriptor, F_GETFD) >= 0) continue;
    // The lowest free number is this one.
    if (::open("/dev/null", O_RDWR) != descriptor) std::abort();
  }
}

Result<void> finish_standard_output() {
  errno = 0;
  const bool is_written = std::fflush(stdout) == 0;
  if (is_written && std::ferror(stdout) == 0) return {};
  // Of an earlier write that failed the reason is not kept; one more fails for the same one.
  if (is_written) errno = ::write(STDOUT_FILENO, "\n", 1) == 1 ? 0 : errno;
  const std::string reason = errno == 0 ? "an earlier write failed" : std::strerror(errno);
  return fail(ErrorCode::kIo,
              "standard output cannot be written: " + reason + "; what was printed is not whole");
}

}  // namespace tonus
