#include "rig_agent/control/encoder_sign_check.hpp"

#include <algorithm>
#include <cmath>

namespace tonus::control {
namespace {

using Causes = UnexplainedCauses;

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

}  // namespace

EncoderSignCheck::EncoderSignCheck(const JointFriction& friction, double period) noexcept
    : taken_up_(std::pow(kTakenUp + friction.coulomb.norm(), 2)),
      cycles_needed_(static_cast<int>(std::lround(kTimeNeeded / period))),
      window_(period) {
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
  window_.start(unexplained, causes);
  cycles_ = {};
  sound_.numbers.setZero();
  for (Hypothesis& reversed : reversed_) reversed.numbers = 0.5 * (reversed.lowest + reversed.highest);
}

bool EncoderSignCheck::finds_reversed(const Eigen::Vector2d& unexplained, const Columns& causes) noexcept {
  if (!is_started_) start(unexplained, causes);
  window_.take(unexplained, causes);
  if (window_.power() < taken_up_) {
    cycles_ = {};
    return false;
  }
  fit(sound_);
  for (std::size_t k = 0; k < 2; ++k) {
    fit(reversed_[k]);
    const double left = reversed_[k].left;
    const bool is_reversed =
        sound_.left > taken_up_ && sound_.left > kBetter * left && left < kExplained * window_.power();
    cycles_[k] = is_reversed ? cycles_[k] + 1 : 0;
  }
  return std::max(cycles_[0], cycles_[1]) >= cycles_needed_;
}

// |u - S x|^2 = u'u - 2 x'r + x'P x, with P = S'S and r = S'u, falls with the best x_i for all others given,
// one after the other, within their limits.
void EncoderSignCheck::fit(Hypothesis& hypothesis) const noexcept {
  const auto& products = window_.products();
  Numbers& x = hypothesis.numbers;
  Numbers slope = products * x - window_.responses();
  for (int step = 0; step < kSteps; ++step) {
    for (int i = 0; i < Causes::kCount; ++i) {
      if (products(i, i) <= 0.0) continue;
      const double best =
          std::clamp(x[i] - slope[i] / products(i, i), hypothesis.lowest[i], hypothesis.highest[i]);
      slope += (best - x[i]) * products.col(i);
      x[i] = best;
    }
  }
  hypothesis.left = std::max(0.0, window_.power() + x.dot(slope - window_.responses()));
}

}  // namespace tonus::control
