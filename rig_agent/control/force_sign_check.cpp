#include "rig_agent/control/force_sign_check.hpp"

#include <cmath>

namespace tonus::control {
namespace {

constexpr double kTimeNeeded = 0.02;  // s at a stretch
constexpr double kSaid = 0.07;        // N m rms, beside what friction can take up
constexpr double kSilent = 0.02;      // N m rms; so small an s says nothing about its sensor
constexpr double kReversed = 1.5;     // 1 - g
constexpr double kExplained = 0.5;    // of u: else something else is at work
constexpr double kBetter = 1.25;      // than a model that is wrong
constexpr double kModelError = 0.33;  // of the inertial torques
constexpr double kForceError = 0.1;   // of the loads

}  // namespace

ForceSignCheck::ForceSignCheck(const ServoGains& gains, const JointFriction& friction, double period) noexcept
    : taken_up_(kSaid + friction.coulomb.norm()),
      cycles_needed_(static_cast<int>(std::lround(kTimeNeeded / period))),
      response_(gains, period),
      window_(period) {}

void ForceSignCheck::start(const Eigen::Vector2d& unexplained, const Columns& said) noexcept {
  is_started_ = true;
  response_.start(said);
  window_.start(unexplained, said);
  cycles_reversed_.setZero();
}

bool ForceSignCheck::finds_reversed(const Eigen::Vector2d& unexplained, const Eigen::Matrix2d& loads,
                                    const Eigen::Matrix2d& accelerations) noexcept {
  Columns said;
  said << loads, accelerations;
  if (!is_started_) start(unexplained, said);
  window_.take(unexplained, response_.pass(said));
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
      window_.products().block<2, 2>(first, first) + kSilent * kSilent * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d r = window_.responses().segment<2>(first);
  const double determinant = p(0, 0) * p(1, 1) - p(0, 1) * p(1, 0);
  Fit fit;
  fit.excess =
      Eigen::Vector2d(p(1, 1) * r[0] - p(0, 1) * r[1], p(0, 0) * r[1] - p(0, 1) * r[0]) / determinant;
  fit.own = Eigen::Vector2d(determinant / p(1, 1), determinant / p(0, 0));
  fit.explained = fit.excess.dot(r);
  return fit;
}

bool ForceSignCheck::explains_most(const Fit& channels) const noexcept {
  const auto said = window_.products().diagonal();
  const double by_model =
      kForceError * kForceError * (said[0] + said[1]) + kModelError * kModelError * (said[2] + said[3]);
  return channels.explained - by_model >= kExplained * window_.power() &&
         channels.explained >= kBetter * fit(2).explained;
}

}  // namespace tonus::control
