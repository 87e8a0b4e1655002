#pragma once

#include <utility>

namespace tonus {

/// Owns an open file of the operating system, or none.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  /// Takes over what open(2) returned; a negative number: none.
  explicit FileDescriptor(int descriptor) : descriptor_(descriptor) {}
  FileDescriptor(FileDescriptor&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~FileDescriptor() { (void)close(); }

  [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
  [[nodiscard]] int get() const { return descriptor_; }

  /// False: the system reports (in errno) that what was written may not be there. Nothing is owned
  /// afterwards.
  [[nodiscard]] bool close();

 private:
  int descriptor_ = -1;
};

}  // namespace tonus
