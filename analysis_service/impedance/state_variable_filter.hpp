#pragma once

#include <Eigen/Core>

namespace tonus::impedance {

/// One sample step of the state-variable filter (8),
///
///     T(s) = wn^2 / (s^2 + 2 zeta wn s + wn^2),
///
/// discretised exactly for a first-order hold: between samples the input runs along a straight line. State
/// s = (y, y'), the filtered signal and its first derivative:
///
///     s[k+1] = Phi s[k] + G0 u[k] + G1 u[k+1],    y"[k] = wn^2 (u[k] - y[k]) - 2 zeta wn y'[k].
///
/// T(0) = 1: in the steady state a constant passes unchanged.
struct StateVariableStep {
  Eigen::Matrix2d Phi;  ///< exp(A h).
  Eigen::Vector2d G0;
  Eigen::Vector2d G1;
  double stiffness = 0.0;  ///< wn^2, 1/s^2.
  double damping = 0.0;    ///< 2 zeta wn, 1/s.

  /// natural_frequency in Hz (wn / 2 pi), more than 0; damping_ratio more than 0; sample_period in s, more
  /// than 0.
  [[nodiscard]] static StateVariableStep make(double natural_frequency, double damping_ratio,
                                              double sample_period);
};

/// State-variable filter of several signals, sample by sample. Its states are the filtered signals and their
/// first two derivatives, so nothing is differenced. Starts at rest, the sample before the
/// first being zero: feed signals whose mean at rest has
/// been taken away, from rest on, and no transient arises. The same filter on both sides of
/// F = M X" + B X' + K X + c keeps the equation exact: T F = M (T X)" + B (T X)' + K T X + c, where c is a
/// constant that stood long before the filter started and therefore passes unchanged.
/// Fixed size: allocates nothing, may run in a realtime thread.
template <int kSignals>
class StateVariableFilter {
 public:
  using Values = Eigen::Array<double, kSignals, 1>;

  explicit StateVariableFilter(const StateVariableStep& step) : step_(step) {}

  /// Takes the next sample of each signal.
  void push(const Values& input) {
    const Values y =
        step_.Phi(0, 0) * value_ + step_.Phi(0, 1) * rate_ + step_.G0[0] * previous_ + step_.G1[0] * input;
    rate_ =
        step_.Phi(1, 0) * value_ + step_.Phi(1, 1) * rate_ + step_.G0[1] * previous_ + step_.G1[1] * input;
    value_ = y;
    acceleration_ = step_.stiffness * (input - value_) - step_.damping * rate_;
    previous_ = input;
  }

  /// Back to rest at zero.
  void reset() { *this = StateVariableFilter(step_); }

  [[nodiscard]] const Values& value() const { return value_; }                ///< y
  [[nodiscard]] const Values& rate() const { return rate_; }                  ///< y'
  [[nodiscard]] const Values& acceleration() const { return acceleration_; }  ///< y"

 private:
  StateVariableStep step_;
  Values previous_ = Values::Zero();
  Values value_ = Values::Zero();
  Values rate_ = Values::Zero();
  Values acceleration_ = Values::Zero();
};

}  // namespace tonus::impedance
