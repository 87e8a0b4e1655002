#pragma once

#include <string>
#include <utility>

#include "services/core/file_descriptor.hpp"
#include "services/core/result.hpp"

namespace tonus::store {

/// The right to be the only one that writes a store: a lock on a file beside it, PATH-lock, that ends with
/// the program however it ends. Readers need no lock.
class StoreLock {
 public:
  /// kUnavailable where another program writes the store; kIo where the file cannot be made.
  [[nodiscard]] static Result<StoreLock> take(const std::string& store_path);

  /// Whether a program writes the store now. Makes no file and needs no right to write.
  [[nodiscard]] static bool is_taken(const std::string& store_path);

  StoreLock(StoreLock&&) noexcept = default;
  StoreLock& operator=(StoreLock&&) = delete;
  ~StoreLock();

 private:
  StoreLock(std::string path, FileDescriptor file) : path_(std::move(path)), file_(std::move(file)) {}

  std::string path_;
  FileDescriptor file_;
};

}  // namespace tonus::store
