#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "services/core/record_file.hpp"
#include "services/core/result.hpp"

namespace tonus::rig {

struct SpoolOptions {
  std::filesystem::path folder;
  std::uint64_t max_bytes = 4ULL << 30;  ///< Beyond this no new trial is begun.
  /// Received samples are kept while the spool is smaller than this, at most half of max_bytes.
  std::uint64_t retained_bytes = 1ULL << 30;
  std::uint64_t segment_bytes = 16ULL << 20;  ///< Size at which a new file is begun, at most max_bytes / 8.
};

/// Where a run of samples is kept.
struct SpooledRange {
  std::uint64_t epoch = 0;
  std::uint64_t first_sequence = 0;
  std::uint64_t last_sequence = 0;
};

/// The rig's own copy of every block of samples, with the values of the auxiliary channels during them, on
/// its disk, until the archive has them for good.
///
/// Blocks are kept as the bytes that were published, in files of a bounded size per epoch (start of the
/// agent). append() hands a block to the operating system, so that it survives the program's death; sync()
/// makes it survive the machine's. received() allows blocks to be forgotten, oldest first, and only when room
/// is needed: until then a restarted consumer can ask for them again. Samples that nobody has receipted are
/// never removed; when they fill the spool, is_full() says so and the agent refuses new trials. One thread.
class Spool {
 public:
  /// A block's two messages; the second one is empty where the rig has no auxiliary channels.
  struct Messages {
    std::span<const std::byte> samples;
    std::span<const std::byte> auxiliary;
  };
  using Visitor = std::function<void(const Messages& messages)>;

  /// Reads back what earlier runs left. kIo names the file and the reason.
  [[nodiscard]] static Result<Spool> open(const SpoolOptions& options);

  /// Keeps one block of `count` samples from `first_sequence` on, whole or not at all.
  [[nodiscard]] Result<void> append(std::uint64_t epoch, std::uint64_t first_sequence, std::uint32_t count,
                                    const Messages& messages);

  /// Every sample of the epoch from `first` up to but not including `through` is safe elsewhere. False, and
  /// nothing follows from it, where that cannot be true or does not help: of samples that were never kept
  /// here, or of a later part while samples before `first` have no receipt.
  bool received(std::uint64_t epoch, std::uint64_t first, std::uint64_t through);

  /// Visits the blocks that hold any of first .. last, in order. kDataLoss if one of them is damaged: it is
  /// left out and the others are visited all the same.
  [[nodiscard]] Result<void> read(std::uint64_t epoch, std::uint64_t first, std::uint64_t last,
                                  const Visitor& visit) const;

  /// Runs of samples without a receipt, epochs other than `current` only: what an earlier run left behind.
  [[nodiscard]] std::vector<SpooledRange> left_behind(std::uint64_t current) const;

  /// Highest sequence kept of an epoch; none: no sample is.
  [[nodiscard]] std::optional<std::uint64_t> last_sequence(std::uint64_t epoch) const;

  [[nodiscard]] Result<void> sync();
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  [[nodiscard]] bool is_full() const { return bytes_ >= options_.max_bytes; }

 private:
  struct Block {
    std::uint64_t first_sequence;
    std::uint32_t count;
    std::uint64_t offset;
  };
  struct Segment {
    std::uint64_t epoch;
    RecordFile file;
    std::vector<Block> blocks;  // in order of first_sequence
  };

  explicit Spool(SpoolOptions options);
  [[nodiscard]] Result<void> begin_segment(std::uint64_t epoch, std::uint64_t first_sequence);
  [[nodiscard]] std::uint64_t first_sequence(std::uint64_t epoch) const;
  [[nodiscard]] bool is_received(const Segment& segment) const;
  void forget_received();

  SpoolOptions options_;
  std::deque<Segment> segments_;                             // oldest first
  std::map<std::uint64_t, std::uint64_t> received_through_;  // by epoch
  std::uint64_t bytes_ = 0;
};

}  // namespace tonus::rig
