#pragma once

#include <string>

#include "services/archive/disk_budget.hpp"
#include "services/archive/ingest.hpp"
#include "services/bus/bus.hpp"
#include "services/core/clock.hpp"

namespace tonus::archive {

/// Keeps a DiskBudget up to date: with the store's space, asked for once a second, and with what the bus says
/// of rig and session. What it says changes only with the cause, not with every byte that is written: each
/// change is published, and stored. For one thread.
class DiskWatch {
 public:
  DiskWatch(store::Store& store, const Clock& clock, const DiskBudget::Options& options)
      : store_(store), clock_(clock), budget_(store.name(), options) {}

  /// Looks at a message of any topic that the archive keeps. One that does not decode says nothing.
  void note(const bus::TopicSpec& topic, const bus::Sample& sample);

  /// Asks the store where it is due; returns when it is due next.
  Clock::TimePoint measure_if_due(const IngestStatus& taken);

  /// Why no trial may be begun now, a line for a person; empty: there is room.
  [[nodiscard]] std::string refusal() const { return failure_.empty() ? refusal_ : failure_; }

  /// What a session that has not begun needs, to be shown in the health: says that its plan was seen.
  [[nodiscard]] std::string need_text() const { return refusal_.empty() ? need_ : std::string(); }

 private:
  void word();

  store::Store& store_;
  const Clock& clock_;
  DiskBudget budget_;
  std::string failure_;  ///< Why the store did not answer.
  std::string refusal_;
  std::string need_;
  std::uint64_t worded_for_ = 0;  ///< Need of the session that both speak of.
  Clock::TimePoint due_;
};

}  // namespace tonus::archive
