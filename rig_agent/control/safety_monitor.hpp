#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "rig_agent/control/fault.hpp"
#include "rig_agent/control/plausibility.hpp"
#include "rig_agent/control/safety_limits.hpp"
#include "rig_agent/control/servo.hpp"
#include "rig_agent/drivers/driver.hpp"
#include "services/mechanics/rig_geometry.hpp"

namespace tonus::control {

/// The loop's surroundings in one cycle, as far as safety looks at them.
struct Surroundings {
  std::int64_t now_ns = 0;
  unsigned missed_periods = 0;
  std::uint64_t keep_alive = 0;  ///< A count that changes while somebody is there.
  bool is_emergency_stop_asked = false;
  bool is_hold_asked = false;
  bool has_watchdog_tripped = false;
  bool is_trial_running = false;
};

/// Compares every cycle with the limits. What it finds is latched until clear(); what is wrong in this very
/// cycle is kept apart, as the cause that must be gone before. All methods are REALTIME.
class SafetyMonitor {
 public:
  SafetyMonitor(const SafetyLimits& limits, const ServoGains& gains, const JointFriction& friction,
                const RigGeometry& geometry, double period, bool actuates);

  /// Starts a cycle with what needs no conversion: driver, emergency stop, time-outs, raw values. True when
  /// the raw values may be used.
  bool begin_cycle(drivers::DriverStatus status, const drivers::Reading& reading,
                   const Surroundings& around) noexcept;
  /// Workspace, speed and force. Speed is the larger of the observer's and of the way measured in the last
  /// two cycles (at rates above 1 kHz: in the last 2 ms), so that it waits for no filter.
  void check_handle(const HandleEstimate& handle) noexcept;
  /// Whether what the sensors say can be true. Call in every cycle whose raw values may be used.
  void check_plausibility(const PlausibilityInput& input) noexcept;
  /// Torque that was asked for. True when it may be written.
  bool check_torque(const Eigen::Vector2d& torque) noexcept;
  void check_write(drivers::DriverStatus status) noexcept;

  /// Clears all, when nothing is wrong in this cycle. Returns what is.
  FaultBits clear() noexcept;

  [[nodiscard]] FaultBits latched() const noexcept { return latched_; }
  [[nodiscard]] FaultBits present() const noexcept { return present_; }
  [[nodiscard]] bool is_saturated() const noexcept { return (present_ & bit(Fault::kSensorSaturated)) != 0; }

 private:
  void found(Fault fault) noexcept { found(bit(fault)); }
  void found(FaultBits faults) noexcept {
    present_ |= faults;
    latched_ |= faults;
  }

  void forget_motion() noexcept {
    has_last_angles_ = false;
    position_count_ = 0;
  }

  void check_raw(const RawSample& raw) noexcept;
  void check_force_channels(const RawSample& raw) noexcept;
  [[nodiscard]] double measured_speed(const Eigen::Vector2d& position) noexcept;
  void check_commander(const Surroundings& around) noexcept;
  void check_periods(unsigned missed_periods) noexcept;

  const SafetyLimits limits_;
  const RigGeometry geometry_;
  const double period_;
  const bool actuates_;
  const std::uint64_t speed_cycles_;
  const double missed_filter_;  // Share of one period in the share of missed ones.
  Plausibility plausibility_;
  double missed_share_ = 0.0;
  std::int64_t last_acquisition_ns_ = 0;
  FaultBits latched_ = 0;
  FaultBits present_ = 0;
  bool has_last_angles_ = false;
  Eigen::Vector2d last_angles_ = Eigen::Vector2d::Zero();
  std::array<double, 2> last_force_V_{};
  std::array<Eigen::Vector2d, 16> positions_;  // Ring of the last handle positions, m in R.
  std::uint64_t position_count_ = 0;
  double last_speed_ = 0.0;  // m/s
  std::uint64_t last_keep_alive_ = 0;
  std::int64_t heard_ns_ = 0;
  bool was_trial_running_ = false;
};

}  // namespace tonus::control
