#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "services/core/file_descriptor.hpp"
#include "services/core/result.hpp"

namespace tonus::rig {

/// What keeps a rig held across restarts: on disk, whether the rig is held and why, and whether it was under
/// power. A rig whose last agent ended under power, or whose file cannot be read, is held from the start.
///
/// The file has two slots of fixed size, written in turn and each closed by a checksum, so that a write that
/// is torn leaves the state before it, and a full disk does not stop a hold from being written. One thread.
class HoldLatch {
 public:
  /// A rig that was never held has no file: it is made, and the rig is free. kIo where the file cannot be
  /// opened; what it holds is never a reason to refuse, but to hold.
  [[nodiscard]] static Result<HoldLatch> open(const std::filesystem::path& path);

  [[nodiscard]] bool is_held() const { return !because_.empty(); }
  /// Of the hold in force, 1, 2, ... in the rig's life; 0: not held.
  [[nodiscard]] std::uint32_t number() const { return is_held() ? number_ : 0; }
  /// A line for a person; empty: not held.
  [[nodiscard]] const std::string& because() const { return because_; }

  /// Whether only an operator may clear the hold in force, also on a rig that moves nothing real.
  [[nodiscard]] bool needs_operator() const { return needs_operator_; }

  /// Holds the rig, in memory in any case; a second reason is added to the first, and one that is known is
  /// not written again. kIo: not on disk.
  [[nodiscard]] Result<void> hold(const std::string& because, bool needs_operator = true);
  /// Frees the rig. kInvalidArgument where another hold is in force than `number`; kIo: still held.
  [[nodiscard]] Result<void> clear(std::uint32_t number);
  /// Call before the driver is activated, and after it was deactivated. kIo: not on disk.
  [[nodiscard]] Result<void> set_powered(bool is_powered);

 private:
  HoldLatch(std::filesystem::path path, FileDescriptor file)
      : path_(std::move(path)), file_(std::move(file)) {}
  void load();
  [[nodiscard]] Result<void> write();

  std::filesystem::path path_;
  FileDescriptor file_;
  std::uint64_t version_ = 0;  // of the state; its parity is the slot
  std::uint32_t number_ = 0;   // of the last hold
  std::string because_;
  bool needs_operator_ = false;
  bool is_powered_ = false;
  bool is_on_disk_ = false;
};

}  // namespace tonus::rig
