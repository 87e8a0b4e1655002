#include "rig_agent/control/damping_watch.hpp"

#include <algorithm>
#include <cmath>

namespace tonus::control {

DampingWatch::DampingWatch(double observer_frequency, double period) noexcept
    : period_(period),
      settling_cycles_(static_cast<int>(std::lround(kSettling / period))),
      load_(observer_frequency, period) {}

void DampingWatch::begin() noexcept {
  has_driven_ = false;
  restart();
}

void DampingWatch::restart() noexcept {
  cycles_ = 0;
  load_.start(Eigen::Vector2d::Zero());
  given_ = 0.0;
  largest_ = 0.0;
  lowest_ = 0.0;
}

bool DampingWatch::takes_energy(const Eigen::Matrix2d& mass_matrix, const Eigen::Vector2d& rates,
                                const Eigen::Vector2d& load) noexcept {
  if (has_driven_) return false;
  given_ += period_ * rates.dot(load_.pass(load));
  const double kinetic = 0.5 * rates.dot(mass_matrix * rates);
  const double balance = kinetic + given_;
  if (cycles_ < settling_cycles_) {
    ++cycles_;
    lowest_ = balance;
    return true;
  }
  largest_ = std::max(largest_, kinetic);
  lowest_ = std::min(lowest_, balance);
  has_driven_ = !(balance - lowest_ <= kShare * largest_ + kFloor);
  return !has_driven_;
}

}  // namespace tonus::control
