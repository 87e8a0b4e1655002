#include "services/core/file_descriptor.hpp"

#include <unistd.h>

namespace tonus {

bool FileDescriptor::close() { return descriptor_ < 0 || ::close(std::exchange(descriptor_, -1)) == 0; }

}  // namespace tonus
