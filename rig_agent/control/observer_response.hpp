#pragma once

#include <Eigen/Core>
#include <cmath>

#include "rig_agent/control/observer_lag.hpp"
#include "rig_agent/control/servo.hpp"
#include "rig_agent/control/servo_gains.hpp"

namespace tonus::control {

/// What Servo::unexplained_torque() shows of joint torques that the observer did not predict.
///
/// The observer answers an acceleration that it did not predict late (ObserverLag), and what it finds is
/// low-passed at kUnexplainedFilter. A column of torques (N m at the two joints) that has passed the same can
/// be compared with it. Torques from before start() are
/// forgotten, the observer still answers them: the first kSettling seconds compare nothing.
///
/// All methods are REALTIME.
template <int kColumns>
class ObserverResponse {
 public:
  using Columns = Eigen::Matrix<double, 2, kColumns>;
  static constexpr double kSettling = 0.3;  // s; leaves 2 % of what was there before

  /// `period` in s.
  ObserverResponse(const ServoGains& gains, double period) noexcept
      : lag_(gains.observer_frequency, period),
        unexplained_share_(1.0 - std::exp(-kUnexplainedFilter * period)),
        settling_cycles_(static_cast<int>(std::lround(kSettling / period))) {}

  void start(const Columns& torques) noexcept {
    lag_.start(torques);
    shown_ = torques;
    cycles_left_ = settling_cycles_;
  }

  const Columns& pass(const Columns& torques) noexcept {
    shown_ += unexplained_share_ * (lag_.pass(torques) - shown_);
    if (cycles_left_ > 0) --cycles_left_;
    return shown_;
  }

  [[nodiscard]] bool is_settled() const noexcept { return cycles_left_ == 0; }

 private:
  ObserverLag<kColumns> lag_;
  const double unexplained_share_;  // Of the new value in one cycle.
  const int settling_cycles_;
  int cycles_left_ = 0;
  Columns shown_ = Columns::Zero();
};

}  // namespace tonus::control
