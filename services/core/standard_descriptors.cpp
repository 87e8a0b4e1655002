#include "services/core/standard_descriptors.hpp"

#include <cstdlib>
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

}  // namespace tonus
