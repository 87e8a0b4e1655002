#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "services/core/record_storage.hpp"
#include "services/core/result.hpp"

namespace tonus {

/// A file of records that only grows: each is a length, a CRC-32C of length and content, and the content.
/// Written records survive the program's death at once, and the machine's after sync().
///
/// A program killed in the middle of a write leaves a torn end: a last record that is shorter than its length
/// says, or zeros. open() cuts it off. Anything else that is no good record is damage (a flipped bit, an
/// overwritten page): it stays where it is, what it held is lost, and reading resumes at the next good
/// record that is not empty, wherever that begins. Damage can name a length of its own, so that it is
/// searched byte by byte.
class RecordFile {
 public:
  static constexpr std::size_t kMaxRecord = 1U << 20;

  struct DamagedBytes {
    std::uint64_t offset;
    std::uint64_t count;
  };

  /// Called for each good record: where it starts in the file and its content.
  using Visitor = std::function<void(std::uint64_t offset, std::span<const std::byte> content)>;

  /// Visits the good records, cuts a torn end and stands ready to append.
  [[nodiscard]] static Result<RecordFile> open(std::unique_ptr<RecordStorage> storage, const Visitor& visit);

  /// The same of a file, which is made where it is absent. kIo names the file and the operating system's
  /// reason.
  [[nodiscard]] static Result<RecordFile> open(const std::filesystem::path& path, const Visitor& visit);

  /// Appends one record; returns where it starts. kInvalidArgument over kMaxRecord; kIo if it was not written
  /// whole, and the file is as it was before.
  [[nodiscard]] Result<std::uint64_t> append(std::span<const std::byte> content);

  /// The record at an offset that append() or the visitor gave; kDataLoss if its checksum is wrong.
  [[nodiscard]] Result<std::vector<std::byte>> read(std::uint64_t offset) const;

  /// Cuts off damage that reaches to the end, for an owner to whom no record that may have stood there was
  /// promised.
  [[nodiscard]] Result<void> cut_damaged_end();

  /// Takes the place of the file at `path`, in the same folder. kIo: this file keeps its name.
  [[nodiscard]] Result<void> rename_to(const std::filesystem::path& path);

  /// Waits until everything appended so far is on the disk.
  [[nodiscard]] Result<void> sync();

  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] std::uint64_t torn_bytes() const { return torn_bytes_; }  ///< Cut off.

  /// Runs of bytes that were no records when the file was opened, in order; they are still there.
  [[nodiscard]] const std::vector<DamagedBytes>& damage() const { return damage_; }

  /// Whether the last of them reaches to the end.
  [[nodiscard]] bool ends_damaged() const;

  /// What was lost, a line for a person and the log; empty: nothing.
  [[nodiscard]] std::string damage_text() const;
  [[nodiscard]] const std::filesystem::path& path() const { return storage_->path(); }

 private:
  explicit RecordFile(std::unique_ptr<RecordStorage> storage) : storage_(std::move(storage)) {}

  std::unique_ptr<RecordStorage> storage_;
  std::uint64_t size_ = 0;
  std::uint64_t torn_bytes_ = 0;
  std::vector<DamagedBytes> damage_;
};

}  // namespace tonus
