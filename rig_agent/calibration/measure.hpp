#pragma once

#include <vector>

#include "rig_agent/calibration/calibration.hpp"
#include "rig_agent/control/pacer.hpp"
#include "rig_agent/control/rig_loop.hpp"
#include "rig_agent/drivers/driver.hpp"
#include "services/core/result.hpp"

namespace tonus::calibration {

/// The cycles of a rig, by the clock, or at once where the driver's time is its own.
class Cycles {
 public:
  Cycles(const drivers::Driver& driver, double period);
  /// Waits for the next cycle.
  control::CycleStart next() noexcept;
  [[nodiscard]] double period() const { return period_; }

 private:
  const bool has_own_clock_;
  const double period_;
  control::MonotonicClock clock_;
  control::Pacer pacer_;
  std::int64_t now_ns_ = 0;
};

/// Means over a time (s), the motors without torque. Fails where the driver does, where a force channel is
/// saturated, and where an encoder moves by more than two counts to either side: the rig is not at rest.
[[nodiscard]] Result<RestReading> read_at_rest(drivers::Driver& driver, Cycles& cycles, double time);

struct SpringPlan {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< m in R, where the handle is led to first.
  unsigned directions = 12;                         ///< Equally spaced, from R's x axis.
  double amplitude = 0.008;                         ///< m, commanded.
  double hold = 5.0;                                ///< s, long enough for the spring to come to rest.
};

/// Steps against what is fixed to the handle, as trials of the loop: displacement and force in R, from the
/// mean of the last 0.3 s before each onset to that of the last second of its hold. Fails where a trial does.
[[nodiscard]] Result<std::vector<SpringStep>> step_against_spring(control::RigLoop& loop,
                                                                  const RigGeometry& geometry, Cycles& cycles,
                                                                  const SpringPlan& plan);

}  // namespace tonus::calibration
