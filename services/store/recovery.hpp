#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "services/core/progress.hpp"
#include "services/core/result.hpp"
#include "services/store/records.hpp"

namespace tonus::store {

/// Row numbers first .. last of a table.
struct RowRange {
  std::int64_t first = 0;
  std::int64_t last = 0;
};

/// Samples of a stream that were there, as far as the rest of the file tells, and are not any more.
struct LostSamples {
  StreamKey stream;
  SequenceRange range;
};

/// What was copied out of a damaged archive, and what was lost.
struct Recovery {
  std::uint64_t blocks = 0;    ///< Copied.
  std::uint64_t messages = 0;  ///< Copied.
  std::uint64_t sessions = 0;
  std::uint64_t trials = 0;
  std::uint64_t pages = 0;
  std::uint64_t pages_expected = 0;  ///< As the header says; 0: it does not.
  std::uint64_t pages_from_log = 0;  ///< From the write-ahead log beside the file.
  bool has_header = true;
  std::uint64_t unreadable_rows = 0;  ///< On pages of tables, cannot be taken apart.
  std::vector<RowRange>
      lost_blocks;  ///< By number in the table `blocks`: gaps and rows with a wrong checksum.
  std::vector<RowRange> lost_messages;        ///< Likewise of `messages`.
  std::vector<std::string> damaged_messages;  ///< Of those, what is known: topic and key.
  std::vector<LostSamples> lost_samples;
  std::vector<std::string> incomplete_trials;  ///< "session ..., trial 7: 40 of 900 samples missing".

  [[nodiscard]] bool is_whole() const {
    return lost_blocks.empty() && lost_messages.empty() && lost_samples.empty() && unreadable_rows == 0 &&
           (pages_expected == 0 || pages >= pages_expected);
  }
};

/// Copies what can be read of a damaged SQLite archive into a new one at `target`. Every block and message is
/// found by itself, without the file's own index of it, and taken over only with the right checksum;
/// sessions, trials, streams and coverage are made anew from them. `damaged` (and its -wal beside it) is not
/// changed.
///
/// What came after the last row that is left cannot be known to have been there. kAlreadyExists: target.
/// kNotFound: damaged. kDataLoss: it holds nothing of an archive of tonus.
[[nodiscard]] Result<Recovery> recover_archive(const std::filesystem::path& damaged,
                                               const std::filesystem::path& target,
                                               const Progress& progress = {});

}  // namespace tonus::store
