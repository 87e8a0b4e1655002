#pragma once

#include <utility>

#include "services/core/file_descriptor.hpp"
#include "services/core/result.hpp"

namespace tonus::cli {

/// Keeps two systems of this machine out of one DDS domain: held by `tonus up` and `tonus demo` while they
/// run, given up by the operating system however they end.
class DomainLock {
 public:
  /// kAlreadyExists names the domain and the process that has it.
  [[nodiscard]] static Result<DomainLock> take(int domain);

 private:
  explicit DomainLock(FileDescriptor file) : file_(std::move(file)) {}

  FileDescriptor file_;
};

}  // namespace tonus::cli
