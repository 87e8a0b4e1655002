#pragma once

#include <mutex>
#include <optional>

#include "services/core/clock.hpp"
#include "services/core/id.hpp"

#include <idl/rig.h>

namespace tonus::rig {

/// For which session the rig is armed, since when, and when that session's scheduler was last heard. From any
/// thread.
class Lease {
 public:
  Lease(const Id& rig, std::uint64_t epoch) : rig_(rig), epoch_(epoch) {}

  /// Arming counts as a sign of life.
  void arm(const Id& session, Clock::TimePoint now) {
    const std::lock_guard lock(mutex_);
    armed_ = Armed{session, now, now};
  }
  void disarm() {
    const std::lock_guard lock(mutex_);
    armed_.reset();
  }
  /// A lease that names another rig, agent or session is none.
  void hear(const v1::RigLease& lease, Clock::TimePoint now) {
    const std::lock_guard lock(mutex_);
    if (lease.rig_id() != rig_ || lease.epoch() != epoch_) return;
    if (armed_ && armed_->session == lease.session_id()) armed_->heard = now;
  }

  [[nodiscard]] Id session() const {
    const std::lock_guard lock(mutex_);
    return armed_ ? armed_->session : kNoId;
  }
  /// Since the arming; none: not armed.
  [[nodiscard]] std::optional<Clock::Duration> armed_for(Clock::TimePoint now) const {
    const std::lock_guard lock(mutex_);
    return armed_ ? std::optional(now - armed_->since) : std::nullopt;
  }
  /// When the scheduler was last heard; none: not armed.
  [[nodiscard]] std::optional<Clock::TimePoint> heard() const {
    const std::lock_guard lock(mutex_);
    return armed_ ? std::optional(armed_->heard) : std::nullopt;
  }

 private:
  struct Armed {
    Id session = kNoId;
    Clock::TimePoint since;
    Clock::TimePoint heard;
  };

  const Id rig_;
  const std::uint64_t epoch_;
  mutable std::mutex mutex_;
  std::optional<Armed> armed_;
};

}  // namespace tonus::rig
