#include "rig_agent/control/force_sign_check.hpp"

#include <cmath>

#include "rig_agent/control/servo.hpp"

namespace tonus::control {
namespace {

constexpr double kMeanTime = 0.5;     // s
constexpr double kWindow = 0.3;       // s
constexpr double kTimeNeeded = 0.02;  // s at a stretch
constexpr double kSaid = 0.07;        // N m rms, beside what friction can take up
constexpr double kSilent = 0.02;      // N m rms; so small an s says nothing about its sensor
constexpr double kReversed = 1.5;     // 1 - g
constexpr double kExplained = 0.5;    // of u: else something else is at work
constexpr double kBetter = 1.25;      // than a model that is wrong
constexpr double kModelError = 0.33;  // of the inertial torques
constexpr double kForceError = 0.1;   // of the loads

double share(double time, double period) { return 1.0 - std::exp(-period / time); }

}  // namespace

ForceSignCheck::ForceSignCheck(const ServoGains& gains, const JointFriction& friction, double period) noexcept
    : observer_share_(share(1.0 / gains.observer_frequency, period)),
      unexplained_share_(share(1.0 / kUnexplainedFilter, period)),
      mean_share_(share(kMeanTime, period)),
      window_share_(share(kWindow, period)),
      taken_up_(kSaid + friction.coulomb.norm()),
      cycles_needed_(static_cast<int>(std::lround(kTimeNeeded / period))) {}

void ForceSignCheck::start(const Eigen::Vector2d& unexplained, const Columns& said) noexcept {
  is_started_ = true;
  filtered_once_ = said;
  filtered_twice_ = said;
  said_ = said;
  mean_said_ = said;
  mean_unexplained_ = unexplained;
  products_.setZero();
  responses_.setZero();
  power_ = 0.0;
  cycles_reversed_.setZero();
}

// The observer answers an acceleration that it did not predict by w^2 / (s + w)^2, and what it finds is
// low-passed.
void ForceSignCheck::filter(const Eigen::Vector2d& unexplained, const Columns& said) noexcept {
  filtered_once_ += observer_share_ * (said - filtered_once_);
  filtered_twice_ += observer_share_ * (filtered_once_ - filtered_twice_);
  said_ += unexplained_share_ * (filtered_twice_ - said_);
  mean_said_ += mean_share_ * (said_ - mean_said_);
  mean_unexplained_ += mean_share_ * (unexplained - mean_unexplained_);
}

bool ForceSignCheck::finds_reversed(const Eigen::Vector2d& unexplained, const Eigen::Matrix2d& loads,
                                    const Eigen::Matrix2d& accelerations) noexcept {
  Columns said;
  said << loads, accelerations;
  if (!is_started_) start(unexplained, said);
  filter(unexplained, said);
  const Columns s = said_ - mean_said_;
  const Eigen::Vector2d u = unexplained - mean_unexplained_;
  products_ += window_share_ * (s.transpose() * s - products_);
  responses_ += window_share_ * (s.transpose() * u - responses_);
  power_ += window_share_ * (u.squaredNorm() - power_);
  const Fit channels = fit(0);
  const bool is_explained = explains_most(channels);
  for (int k = 0; k < 2; ++k) {
    const bool is_reversed =
        is_explained && channels.own[k] > 0.25 * taken_up_ * taken_up_ && channels.excess[k] > kReversed;
    cycles_reversed_[k] = is_reversed ? cycles_reversed_[k] + 1 : 0;
  }
  return cycles_reversed_.maxCoeff() >= cycles_needed_;
}

ForceSignCheck::Fit ForceSignCheck::fit(int first) const noexcept {
  const Eigen::Matrix2d p =
      products_.block<2, 2>(first, first) + kSilent * kSilent * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d r = responses_.segment<2>(first);
  const double determinant = p(0, 0) * p(1, 1) - p(0, 1) * p(1, 0);
  Fit fit;
  fit.excess =
      Eigen::Vector2d(p(1, 1) * r[0] - p(0, 1) * r[1], p(0, 0) * r[1] - p(0, 1) * r[0]) / determinant;
  fit.own = Eigen::Vector2d(determinant / p(1, 1), determinant / p(0, 0));
  fit.explained = fit.excess.dot(r);
  return fit;
}

bool ForceSignCheck::explains_most(const Fit& channels) const noexcept {
  const double by_model = kForceError * kForceError * (products_(0, 0) + products_(1, 1)) +
                          kModelError * kModelError * (products_(2, 2) + products_(3, 3));
  return channels.explained - by_model >= kExplained * power_ &&
         channels.explained >= kBetter * fit(2).explained;
}

}  // namespace tonus::control
