#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "services/store/store.hpp"

#include <idl/archive.h>
#include <idl/rig.h>
#include <idl/trial.h>

namespace tonus::archive::testing {

/// A rig that runs trial after trial of the same length, without time or bus of its own, keeps what no
/// receipt covers, and remembers every receipt. What a sample holds follows from its number alone, so that it
/// can be told whether a store has what was sent.
class MadeUpRig {
 public:
  static constexpr std::uint64_t kTrialSamples = 1400;

  struct Trial {
    Id id{};
    std::uint32_t attempt = 0;
    store::SequenceRange range;
  };

  explicit MadeUpRig(std::uint64_t epoch) : epoch_(epoch) {}

  [[nodiscard]] static Id id() { return id_of("rig/campaign"); }
  [[nodiscard]] static Id session() { return id_of("session of the campaign"); }
  [[nodiscard]] store::StreamKey stream() const { return {id(), epoch_}; }

  /// Runs one more trial.
  Trial next_trial();

  /// Samples from `first` on, at most `most`, all of one trial and below next_sequence().
  [[nodiscard]] v1::SampleBlock block(std::uint64_t first, std::uint32_t most, bool is_resent) const;
  [[nodiscard]] v1::TrialOutcome outcome(const Trial& trial) const;
  [[nodiscard]] v1::RigState state() const;

  /// Takes a receipt; one that speaks of samples that never were is an error.
  [[nodiscard]] Result<void> receive(const v1::ArchiveReceipt& receipt);

  [[nodiscard]] std::uint64_t next_sequence() const { return next_; }
  [[nodiscard]] std::uint64_t through() const { return through_; }  ///< Of the receipts for the stream.
  [[nodiscard]] std::size_t receipts() const { return receipts_; }
  [[nodiscard]] std::vector<Trial> trials_without_receipt() const;

  /// kDataLoss where the store misses, or has otherwise than sent, a sample or a trial that a receipt was
  /// given for.
  [[nodiscard]] Result<void> check(store::Store& store) const;

 private:
  [[nodiscard]] static Trial trial_at(std::uint64_t sequence);
  [[nodiscard]] Result<void> check_samples(store::Store& store, store::SequenceRange range) const;

  std::uint64_t epoch_;
  std::uint64_t next_ = 0;
  std::uint64_t through_ = 0;
  std::size_t receipts_ = 0;
  std::map<std::uint32_t, Trial> open_;       ///< By attempt: no receipt yet.
  std::map<std::uint32_t, Trial> certified_;  ///< By attempt.
};

}  // namespace tonus::archive::testing
