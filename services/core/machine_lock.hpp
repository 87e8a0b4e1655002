#pragma once

#include <string>
#include <sys/types.h>

#include "services/core/file_descriptor.hpp"
#include "services/core/result.hpp"

namespace tonus {

/// A name that one process of this machine has at a time, whoever its user is: a Linux abstract socket. There
/// is no file to be left behind, linked elsewhere or forbidden; the kernel gives the name up when the process
/// ends, however it ends. Processes in different network namespaces do not see each other's names.
class MachineLock {
 public:
  /// kAlreadyExists: "NAME is in use by process PID"; kIo: the system's reason.
  [[nodiscard]] static Result<MachineLock> take(const std::string& name);

 private:
  explicit MachineLock(FileDescriptor socket) : socket_(std::move(socket)) {}

  FileDescriptor socket_;
};

}  // namespace tonus
