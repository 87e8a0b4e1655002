#pragma once

#include "services/core/result.hpp"

namespace tonus::cli {

/// Keeps two systems of this machine out of one DDS domain: held by `tonus up` and `tonus demo` while they
/// run, given up by the operating system however they end.
class DomainLock {
 public:
  /// kAlreadyExists names the domain and the process that has it.
  [[nodiscard]] static Result<DomainLock> take(int domain);

  DomainLock(DomainLock&& other) noexcept;
  DomainLock& operator=(DomainLock&&) = delete;
  ~DomainLock();

 private:
  explicit DomainLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_ = -1;
};

}  // namespace tonus::cli
