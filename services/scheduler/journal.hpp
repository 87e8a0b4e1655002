#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "services/core/record_file.hpp"
#include "services/core/result.hpp"
#include "services/scheduler/records.hpp"

namespace tonus::scheduler {

/// A session's write-ahead log, append only: a RecordFile. Each of its records is a number (u32, little
/// endian, from 0) and content. Record 0 holds the hash of the contract that the programs in it were written
/// with; each further one the decisions of one append(). An append is whole or not there: it is synced before
/// it returns. A last record that is torn or damaged, which no append returned for, is cut when the journal
/// is opened. A bad record with a good one after it is damage, and refused.
class Journal {
 public:
  /// Starts a journal in an empty storage.
  [[nodiscard]] static Result<Journal> create(std::unique_ptr<RecordStorage> storage,
                                              std::string_view contract);

  struct Opened;
  /// Reads a journal back. kDataLoss: damaged, or not a journal; kInvalidArgument: of another contract.
  [[nodiscard]] static Result<Opened> open(std::unique_ptr<RecordStorage> storage, std::string_view contract);

  /// Returns when the records are on the disk. After an error nothing may be appended any more: what is on
  /// the disk is not known until the journal has been opened anew.
  [[nodiscard]] Result<void> append(const std::vector<Record>& records);

 private:
  explicit Journal(RecordFile file) : file_(std::move(file)) {}
  [[nodiscard]] Result<void> append_numbered(std::string_view content);

  RecordFile file_;
  std::uint32_t next_number_ = 0;
  bool has_failed_ = false;
};

struct Journal::Opened {
  Journal journal;
  std::vector<Record> records;
  std::size_t cut_bytes = 0;  ///< Length of the torn tail that was cut.
};

/// A journal's record as RecordFile holds it.
[[nodiscard]] std::string numbered(std::uint32_t number, std::string_view content);

}  // namespace tonus::scheduler
