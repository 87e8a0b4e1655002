#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <thread>

#include "services/bus/bus.hpp"
#include "services/core/clock.hpp"
#include "services/core/result.hpp"

#include <idl/rig.h>

namespace tonus::scheduler {

/// Tells the rig that its session's scheduler is alive, ten times a second, on a bus of its own: no reader
/// that stands still can hold it up. The lease is given only while the scheduler's own thread goes on, too.
/// Works in a thread of its own, or by step() where there is to be but one thread.
class LeaseSender {
 public:
  /// Longest that the scheduler's thread may be silent before its lease is withheld.
  static constexpr std::chrono::seconds kLongestSilence{3};

  enum class Works : std::uint8_t { kInOwnThread, kByStep };

  /// `bus` is not shared with anything else.
  [[nodiscard]] static Result<std::unique_ptr<LeaseSender>> create(std::unique_ptr<bus::Bus> bus,
                                                                   const Clock& clock,
                                                                   Works works = Works::kInOwnThread);
  ~LeaseSender();
  LeaseSender(const LeaseSender&) = delete;
  LeaseSender& operator=(const LeaseSender&) = delete;

  /// What is armed now (none: no lease is given); counts as a sign of life. From the scheduler's thread.
  void set(const std::optional<v1::RigLease>& lease);

  /// Of kByStep: gives the lease; returns when to call again at the latest. A lease that set() has changed is
  /// given at once.
  Clock::TimePoint step();

 private:
  class Work;
  LeaseSender(std::unique_ptr<Work> work, Works works);

  std::unique_ptr<Work> work_;
  std::thread thread_;
};

}  // namespace tonus::scheduler
