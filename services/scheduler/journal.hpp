#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/result.hpp"
#include "services/scheduler/journal_storage.hpp"
#include "services/scheduler/records.hpp"

namespace tonus::scheduler {

/// A session's write-ahead log, append only. The file is a run of frames, little endian:
///
///     "TNSJ"  u32 length  u32 number  u32 CRC-32 of number and content  content
///
/// Frame 0 holds the hash of the contract that the programs in it were written with; each further one the
/// records of one append(). An append is whole or not there: it is synced before it returns, and a torn last
/// frame, which no append returned for, is cut when the journal is opened. A bad frame with a good one after
/// it is damage, and refused.
class Journal {
 public:
  /// Starts a journal in an empty storage.
  [[nodiscard]] static Result<Journal> create(std::unique_ptr<JournalStorage> storage,
                                              std::string_view contract);

  struct Opened;
  /// Reads a journal back. kDataLoss: damaged, or not a journal; kInvalidArgument: of another contract.
  [[nodiscard]] static Result<Opened> open(std::unique_ptr<JournalStorage> storage,
                                           std::string_view contract);

  /// Returns when the records are on the disk. After an error nothing may be appended any more: what is on
  /// the disk is not known until the journal has been opened anew.
  [[nodiscard]] Result<void> append(const std::vector<Record>& records);

 private:
  explicit Journal(std::unique_ptr<JournalStorage> storage) : storage_(std::move(storage)) {}
  [[nodiscard]] Result<void> append_frame(std::string_view content);

  std::unique_ptr<JournalStorage> storage_;
  std::uint32_t next_number_ = 0;
  bool has_failed_ = false;
};

struct Journal::Opened {
  Journal journal;
  std::vector<Record> records;
  std::size_t cut_bytes = 0;  ///< Length of the torn tail that was cut.
};

/// CRC-32 of ISO 3309 (as in PNG and zip).
[[nodiscard]] std::uint32_t crc32(std::string_view octets, std::uint32_t so_far = 0);

}  // namespace tonus::scheduler
