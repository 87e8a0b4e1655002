#pragma once

#include <string>

#include "services/core/result.hpp"

namespace tonus::archive {

/// The right to be the only one that writes a store: a lock on a file beside it, PATH-lock, that ends with
/// the program however it ends. Readers need no lock.
class StoreLock {
 public:
  /// kUnavailable where another program writes the store; kIo where the file cannot be made.
  [[nodiscard]] static Result<StoreLock> take(const std::string& store_path);

  StoreLock(StoreLock&& other) noexcept;
  StoreLock& operator=(StoreLock&& other) noexcept;
  ~StoreLock();

 private:
  StoreLock(std::string path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

  std::string path_;
  int descriptor_ = -1;
};

}  // namespace tonus::archive
