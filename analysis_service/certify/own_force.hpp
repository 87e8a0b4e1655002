#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "analysis_service/certify/drawn_session.hpp"

namespace tonus::certify {

/// The arm's own force on the handle (Disturbance), step by step, N.
class OwnForce {
 public:
  OwnForce(const Disturbance& disturbance, double step, std::mt19937_64& random)
      : decay_(std::exp(-step / disturbance.drift_time)),
        turn_(std::polar(std::exp(-2.0 * std::numbers::pi * disturbance.tremor_bandwidth * step),
                         2.0 * std::numbers::pi * disturbance.tremor_frequency * step)),
        disturbance_(disturbance),
        random_(random) {
    for (int axis = 0; axis < 2; ++axis) {
      drift_[axis] = disturbance.drift * normal_(random_);
      tremor_[static_cast<std::size_t>(axis)] =
          disturbance.tremor * std::complex<double>(normal_(random_), normal_(random_));
    }
  }

  Eigen::Vector2d next() {
    Eigen::Vector2d force;
    for (int axis = 0; axis < 2; ++axis) {
      auto& tremor = tremor_[static_cast<std::size_t>(axis)];
      if (disturbance_.drift > 0.0)
        drift_[axis] =
            decay_ * drift_[axis] + disturbance_.drift * std::sqrt(1.0 - decay_ * decay_) * normal_(random_);
      if (disturbance_.tremor > 0.0)
        tremor = turn_ * tremor + disturbance_.tremor * std::sqrt(1.0 - std::norm(turn_)) *
                                      std::complex<double>(normal_(random_), normal_(random_));
      force[axis] = drift_[axis] + tremor.real();
    }
    return force;
  }

 private:
  double decay_;
  std::complex<double> turn_;
  const Disturbance& disturbance_;
  std::mt19937_64& random_;
  std::normal_distribution<double> normal_;
  Eigen::Vector2d drift_ = Eigen::Vector2d::Zero();
  std::array<std::complex<double>, 2> tremor_{};
};

}  // namespace tonus::certify
