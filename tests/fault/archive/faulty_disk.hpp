#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

struct sqlite3_file;
struct sqlite3_vfs;

namespace tonus::archive::testing {

/// A disk that fails, under every SQLite connection that this process opens while it exists. What is written
/// goes to real files, and every change since a file's last sync is remembered with what was there before.
///
/// Writes, truncations and syncs are counted. At the chosen ones the disk fails:
/// - kError: the operation is refused. A refused write may have been done in part. A refused sync loses what
///   it was to make durable: of the changes since the last sync some are undone, at once.
/// - kPowerLoss: the operation and all after it are refused. lose_power() then leaves on the disk what was
///   synced and, of the changes after that, each as it was, as it became, or torn into sectors of 512 bytes.
///   A file that was made and never synced may be gone.
///
/// Removals count as durable at once. For one thread, and one at a time in a process.
class FaultyDisk {
 public:
  enum class Failure : std::uint8_t { kError, kPowerLoss };

  explicit FaultyDisk(std::uint64_t seed);
  ~FaultyDisk();
  FaultyDisk(const FaultyDisk&) = delete;
  FaultyDisk& operator=(const FaultyDisk&) = delete;

  /// The operation of this number fails, the first one that is counted being 1.
  void fail_at(std::uint64_t operation, Failure failure) { failures_[operation] = failure; }

  [[nodiscard]] std::uint64_t operations() const { return operations_; }
  [[nodiscard]] bool has_failed() const { return has_failed_; }
  [[nodiscard]] std::uint64_t errors() const { return errors_; }  ///< kError so far.
  [[nodiscard]] bool is_off() const { return is_off_; }

  /// Ends everything; to be called when no connection is open any more. The disk may be used again.
  void lose_power();

  struct File;     ///< What SQLite has of an open file.
  struct Methods;  ///< Its operations.

 private:
  struct Change {
    std::uint64_t offset = 0;
    std::vector<std::byte> before;
    std::vector<std::byte> after;
    std::uint64_t size_before = 0;
    std::uint64_t size_after = 0;
  };
  struct Unsynced {
    bool is_new = false;
    std::vector<Change> changes;
  };
  struct Target;

  [[nodiscard]] bool is_refused(Failure* failure);
  [[nodiscard]] bool is_heads() { return (generator_() & 1U) != 0; }
  void undo(const Unsynced& unsynced, const Target& target);
  void redo_some(const Unsynced& unsynced, const Target& target);
  void redo(const Change& change, const Target& target);

  std::unique_ptr<sqlite3_vfs> vfs_;
  sqlite3_vfs* real_ = nullptr;
  std::mt19937_64 generator_;
  std::uint64_t operations_ = 0;
  std::map<std::uint64_t, Failure> failures_;
  bool has_failed_ = false;
  bool is_off_ = false;
  std::uint64_t errors_ = 0;
  std::map<std::string, Unsynced> unsynced_;
  std::set<std::string> opened_;
};

}  // namespace tonus::archive::testing
