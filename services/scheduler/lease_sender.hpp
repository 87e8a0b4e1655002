#pragma once

#include <memory>
#include <optional>
#include <thread>

#include "services/bus/bus.hpp"
#include "services/core/clock.hpp"
#include "services/core/result.hpp"

#include <idl/rig.h>

namespace tonus::scheduler {

/// Tells the rig that its session's scheduler is alive, ten times a second, on a bus and from a thread of its
/// own: no reader that stands still can hold it up. The lease is given only while the scheduler's own thread
/// goes on, too.
class LeaseSender {
 public:
  /// Longest that the scheduler's thread may be silent before its lease is withheld.
  static constexpr std::chrono::seconds kLongestSilence{3};

  /// `bus` is not shared with anything else.
  [[nodiscard]] static Result<std::unique_ptr<LeaseSender>> create(std::unique_ptr<bus::Bus> bus,
                                                                   const Clock& clock);
  ~LeaseSender();
  LeaseSender(const LeaseSender&) = delete;
  LeaseSender& operator=(const LeaseSender&) = delete;

  /// What is armed now (none: no lease is given); counts as a sign of life. From the scheduler's thread.
  void set(const std::optional<v1::RigLease>& lease);

 private:
  class Work;
  explicit LeaseSender(std::unique_ptr<Work> work);

  std::unique_ptr<Work> work_;
  std::thread thread_;
};

}  // namespace tonus::scheduler
