#pragma once

#include <Eigen/Core>
#include <cmath>

namespace tonus::control {

/// How the observer answers joint torques (N m, columns) that it did not predict: w^2 / (s + w)^2, w =
/// ServoGains::observer_frequency.
///
/// All methods are REALTIME.
template <int kColumns>
class ObserverLag {
 public:
  using Columns = Eigen::Matrix<double, 2, kColumns>;

  /// rad/s, s.
  ObserverLag(double observer_frequency, double period) noexcept
      : share_(1.0 - std::exp(-observer_frequency * period)) {}

  void start(const Columns& torques) noexcept {
    once_ = torques;
    twice_ = torques;
  }

  /// One cycle.
  const Columns& pass(const Columns& torques) noexcept {
    once_ += share_ * (torques - once_);
    twice_ += share_ * (once_ - twice_);
    return twice_;
  }

 private:
  const double share_;  // Of the new value in one cycle.
  Columns once_ = Columns::Zero();
  Columns twice_ = Columns::Zero();
};

}  // namespace tonus::control
