#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "services/core/id.hpp"
#include "services/core/record_file.hpp"
#include "services/core/result.hpp"

#include <idl/trial.h>

namespace tonus::rig {

/// A trial that was begun and of whose end nothing is known: the agent died in it.
struct BrokenTrial {
  v1::TrialCommand command;
  std::uint64_t epoch = 0;
  std::uint64_t first_sequence = 0;
};

/// What the agent has done, on disk, so that after its death the same trial is not run twice and the broken
/// one is reported: trials begun and ended, and what the archive has receipted. Of earlier runs only the
/// newest session is kept. One thread.
class TrialLog {
 public:
  [[nodiscard]] static Result<TrialLog> open(const std::filesystem::path& path);

  /// Call before the loop is told to start the trial.
  [[nodiscard]] Result<void> begun(const v1::TrialCommand& command, std::uint64_t epoch,
                                   std::uint64_t first_sequence);
  [[nodiscard]] Result<void> ended(const v1::TrialOutcome& outcome);
  [[nodiscard]] Result<void> received(std::uint64_t epoch, std::uint64_t through);

  /// Writes everything that is known anew, in a file that then takes the place of this one: how a log that
  /// could not be written becomes whole again.
  [[nodiscard]] Result<void> rewrite();

  /// Outcome of a trial that has ended, if this log knows it.
  [[nodiscard]] const v1::TrialOutcome* find(const Id& trial) const;
  [[nodiscard]] const std::map<Id, v1::TrialOutcome>& outcomes() const { return outcomes_; }
  [[nodiscard]] const std::optional<BrokenTrial>& broken() const { return broken_; }
  [[nodiscard]] const std::map<std::uint64_t, std::uint64_t>& received_through() const { return received_; }

 private:
  explicit TrialLog(RecordFile file) : file_(std::move(file)) {}
  void restore(std::span<const std::byte> content);
  void forget_other_sessions(const Id& session);
  [[nodiscard]] Result<void> write_all();

  RecordFile file_;
  std::map<Id, v1::TrialOutcome> outcomes_;
  std::optional<BrokenTrial> broken_;
  std::map<std::uint64_t, std::uint64_t> received_;
};

}  // namespace tonus::rig
