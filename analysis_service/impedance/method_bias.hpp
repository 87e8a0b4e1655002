#pragma once

#include <cstddef>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/refined/identification.hpp"

namespace tonus::impedance {

/// A condition as it might have been measured, of known M, B, K: for the bias of a method and for what a
/// session's numbers are worth.
///
/// Law: the motion that the trials have in common (refined::CommandMotion) and, computed exactly from it, the
/// force of the impedance `theta`; to both is added what a measured trial has beyond them, displacement and
/// force together, times a sign. So sensor noise, encoder steps, the arm's own force and its way back into
/// the motion through the compliant rig are those of the measured trials, at their own rate, and nothing of
/// them is modelled.
class ResampledCondition {
 public:
  /// `found`: of these trials, with numbers; its M, B, K (less the handle's mass) say what a trial has
  /// beyond.
  ResampledCondition(std::span<const Trial* const> trials, const refined::Estimate& found)
      : ResampledCondition(trials, found.theta, found.motion) {}
  /// The same with another motion.
  ResampledCondition(std::span<const Trial* const> trials, const Eigen::MatrixXd& theta,
                     refined::CommandMotion motion);

  [[nodiscard]] std::size_t size() const { return beyond_.size(); }
  /// M, B, K that the trials are made with unless others are given, X0 empty.
  [[nodiscard]] const Parameters& impedance() const { return impedance_; }

  /// Mean force of the rests that the prediction does not have, N: a bias force.
  [[nodiscard]] const AxisVector& offset() const { return offset_; }

  /// Trial `number` (from 0, towards the target of the measured one) with what trial `of` has beyond, times
  /// `sign`.
  [[nodiscard]] Trial trial(std::size_t number, std::size_t of, double sign,
                            const Parameters& impedance) const;

 private:
  struct Beyond {
    Signals displacement;
    Signals force;
  };
  [[nodiscard]] Beyond predicted(std::size_t number, const Parameters& impedance) const;

  Trial form_;  // what all trials share; no signals
  Eigen::Index rest_ = 0;
  std::vector<Signals> commanded_;
  refined::CommandMotion motion_;
  Parameters impedance_;
  AxisVector offset_;  // N, mean force of the rests: a bias force has no sign of its own
  std::vector<Beyond> beyond_;
};

/// Bias of a published method's M, B, K (model (3)) in this condition, simulated: fits of resampled
/// conditions, each with signs drawn at random and again with the opposite signs, so that what is linear in
/// the noise cancels. Their common motion is mean_motion(): that of a rig fitted to the commands errs by more
/// than state_variable does where the rig follows its command's rate, and needs commands. At most kBiasTrials
/// trials, the first of the condition: a bias does not depend on their number. None where it cannot be
/// simulated. Deterministic.
inline constexpr std::size_t kBiasTrials = 16;
[[nodiscard]] std::optional<Parameters> method_bias(std::span<const Trial* const> trials,
                                                    const refined::Estimate& found, const Options& options,
                                                    double natural_frequency);

/// States the bias beside the numbers; they stay as they are, as do the intervals.
void state_bias(const Parameters& bias, Estimate& estimate);

/// Widens each interval of M, B, K to hold itself and itself plus `change`; ellipses alike. The value stays.
void widen(const Parameters& change, Estimate& estimate);

/// Widens each interval to hold itself and itself less the bias, and states the bias: the value stays what
/// the method gives. Ellipses alike.
void carry_bias(const Parameters& bias, Estimate& estimate);

}  // namespace tonus::impedance
