#pragma once

#include <Eigen/Core>
#include <array>

#include "rig_agent/control/unexplained_causes.hpp"
#include "rig_agent/control/unexplained_window.hpp"
#include "services/mechanics/two_link_dynamics.hpp"

namespace tonus::control {

/// Whether an encoder counts backwards, by torque and motion: two hypotheses of what the observer leaves.
///
/// A reversed encoder leaves twice the acceleration (UnexplainedCauses), but so can a sound rig in a short
/// time: where the arm is about to turn the motion round, a weak motor leaves more than it moves. So both are
/// held against the last third of a second, without its slow mean, each as the least squares of u over all
/// numbers that it allows:
///
/// - sound: any rig that may be there. Motors of 0.2 to 1.5 times their torque, channels off by 15 %, an
///   inertia from two thirds to twice the model's, friction of three times the model's and 0.07 N m besides.
/// - reversed, for each encoder: c = 2, on a rig that is nearly as the law knows it: motors within 30 %,
///   inertia within a third.
///
/// The encoder is reversed where its hypothesis leaves less than a fifth of u, every sound rig leaves four
/// times as much (of the square), and this is more than friction can be.
///
/// All methods are REALTIME.
class EncoderSignCheck {
 public:
  /// `period` in s.
  EncoderSignCheck(const JointFriction& friction, double period) noexcept;

  void begin_trial() noexcept { is_started_ = false; }

  /// Takes u and its possible causes (ObserverResponse), N m at the joints. True where an encoder has been
  /// reversed for some time.
  [[nodiscard]] bool finds_reversed(const Eigen::Vector2d& unexplained,
                                    const UnexplainedCauses::Columns& causes) noexcept;

 private:
  using Columns = UnexplainedCauses::Columns;
  using Numbers = UnexplainedCauses::Numbers;

  struct Hypothesis {
    Numbers lowest = Numbers::Zero();
    Numbers highest = Numbers::Zero();
    Numbers numbers = Numbers::Zero();  // the best as yet
    double left = 0.0;                  // of u, (N m)^2
  };

  void start(const Eigen::Vector2d& unexplained, const Columns& causes) noexcept;
  /// Some more steps towards the least squares; what is left is never less than theirs.
  void fit(Hypothesis& hypothesis) const noexcept;

  const double taken_up_;  // (N m)^2, of what friction can take up
  const int cycles_needed_;

  bool is_started_ = false;
  UnexplainedWindow<UnexplainedCauses::kCount> window_;
  Hypothesis sound_;
  std::array<Hypothesis, 2> reversed_;
  std::array<int, 2> cycles_{};
};

}  // namespace tonus::control
