#include "rig_agent/control/encoder_sign_check.hpp"

#include <algorithm>
#include <cmath>

namespace tonus::control {
namespace {

using Causes = UnexplainedCauses;

constexpr double kMeanTime = 0.5;          // s
constexpr double kWindow = 0.3;            // s
constexpr double kTimeNeeded = 0.02;       // s at a stretch
constexpr double kTakenUp = 0.05;          // N m rms, beside friction
constexpr double kReversed = 2.0;          // c
constexpr double kChannelError = 0.15;     // b, of any rig
constexpr double kInertiaError = 0.5;      // c, of any rig
constexpr double kFrictionError = 2.0;     // times the model's, more than it
constexpr double kFrictionUnknown = 0.07;  // N m besides
constexpr double kMotorNear = 0.3;         // a, of a rig that is nearly as the law knows it
constexpr double kInertiaNear = 0.33;      // c, likewise
constexpr double kExplained = 0.2;         // of u, (N m)^2, that a reversed encoder may leave
constexpr double kBetter = 4.0;            // times as much, that every sound rig leaves
constexpr int kSteps = 6;                  // of each fit in a cycle, from the last cycle's on

double share(double time, double period) { return 1.0 - std::exp(-period / time); }

}  // namespace

EncoderSignCheck::EncoderSignCheck(const JointFriction& friction, double period) noexcept
    : mean_share_(share(kMeanTime, period)),
      window_share_(share(kWindow, period)),
      taken_up_(std::pow(kTakenUp + friction.coulomb.norm(), 2)),
      cycles_needed_(static_cast<int>(std::lround(kTimeNeeded / period))) {
  const Eigen::Vector2d rub = kFrictionError * friction.coulomb + Eigen::Vector2d::Constant(kFrictionUnknown);
  sound_.highest << Causes::kWeakestMotor, Causes::kWeakestMotor, kChannelError, kChannelError, kInertiaError,
      kInertiaError, rub;
  sound_.lowest << Causes::kStrongestMotor, Causes::kStrongestMotor, -kChannelError, -kChannelError,
      -kInertiaError, -kInertiaError, -rub;
  for (int k = 0; k < 2; ++k) {
    Hypothesis& reversed = reversed_[static_cast<std::size_t>(k)];
    reversed.highest << kMotorNear, kMotorNear, kChannelError, kChannelError, kInertiaNear, kInertiaNear, rub;
    reversed.lowest = -reversed.highest;
    reversed.lowest[Causes::kAccelerations + k] += kReversed;
    reversed.highest[Causes::kAccelerations + k] += kReversed;
  }
}

void EncoderSignCheck::start(const Eigen::Vector2d& unexplained, const Columns& causes) noexcept {
  is_started_ = true;
  mean_causes_ = causes;
  mean_unexplained_ = unexplained;
  products_.setZero();
  responses_.setZero();
  power_ = 0.0;
  cycles_ = {};
  sound_.numbers.setZero();
  for (Hypothesis& reversed : reversed_) reversed.numbers = 0.5 * (reversed.lowest + reversed.highest);
}

void EncoderSignCheck::take(const Eigen::Vector2d& unexplained, const Columns& causes) noexcept {
  mean_causes_ += mean_share_ * (causes - mean_causes_);
  mean_unexplained_ += mean_share_ * (unexplained - mean_unexplained_);
  const Columns s = causes - mean_causes_;
  const Eigen::Vector2d u = unexplained - mean_unexplained_;
  products_ += window_share_ * (s.transpose() * s - products_);
  responses_ += window_share_ * (s.transpose() * u - responses_);
  power_ += window_share_ * (u.squaredNorm() - power_);
}

bool EncoderSignCheck::finds_reversed(const Eigen::Vector2d& unexplained, const Columns& causes) noexcept {
  if (!is_started_) start(unexplained, causes);
  take(unexplained, causes);
  if (power_ < taken_up_) {
    cycles_ = {};
    return false;
  }
  fit(sound_);
  for (std::size_t k = 0; k < 2; ++k) {
    fit(reversed_[k]);
    const double left = reversed_[k].left;
    const bool is_reversed =
        sound_.left > taken_up_ && sound_.left > kBetter * left && left < kExplained * power_;
    cycles_[k] = is_reversed ? cycles_[k] + 1 : 0;
  }
  return std::max(cycles_[0], cycles_[1]) >= cycles_needed_;
}

// |u - S x|^2 = u'u - 2 x'r + x'P x, with P = S'S and r = S'u, falls with the best x_i for all others given,
// one after the other, within their limits.
void EncoderSignCheck::fit(Hypothesis& hypothesis) const noexcept {
  Numbers& x = hypothesis.numbers;
  Numbers slope = products_ * x - responses_;
  for (int step = 0; step < kSteps; ++step) {
    for (int i = 0; i < Causes::kCount; ++i) {
      if (products_(i, i) <= 0.0) continue;
      const double best =
          std::clamp(x[i] - slope[i] / products_(i, i), hypothesis.lowest[i], hypothesis.highest[i]);
      slope += (best - x[i]) * products_.col(i);
      x[i] = best;
    }
  }
  hypothesis.left = std::max(0.0, power_ + x.dot(slope - responses_));
}

}  // namespace tonus::control
