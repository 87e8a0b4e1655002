#pragma once

#include <array>
#include <span>
#include <vector>

#include "analysis_service/spectral/segment_fit.hpp"

namespace tonus::spectral {

/// Functions of motion that the linear model does not have.
enum class Term : std::uint8_t {
  kFriction,   ///< sign(x')
  kHardening,  ///< x^3
  kDrag,       ///< x' |x'|
  kPosition,   ///< x^2: stiffness that changes along the axis.
  kReflex,     ///< x(t - delay)
};

/// One term in the fit beside M, B, K and the lag (equation 13).
struct TermFit {
  Term term = Term::kFriction;
  double delay = 0.0;  ///< s, of kReflex.
  int force_axis = 0;
  int motion_axis = 0;
  double coefficient = 0.0;  ///< N for friction, N/m^3, N s^2/m^2, N/m^2, N/m for a reflex.
  double standard_error = 0.0;
  double t = 0.0;                 ///< coefficient / standard_error.
  double share = 0.0;             ///< Of the force's root mean square that the term carries.
  double change = 0.0;            ///< Largest change of M, B, K with it, over the largest element of each.
  double stiffness_change = 0.0;  ///< kPosition: of stiffness over two standard deviations of position.
};

/// Delays at which a reflex is looked for, s.
inline constexpr std::array kReflexDelays{0.030, 0.045, 0.060};

/// Regresses the residual R on each term alone. The displacement that the terms are built from is x^
/// (motion_estimate.hpp), so that the tests keep their level. `records` are those that the fit was made from.
template <int N>
[[nodiscard]] std::vector<TermFit> fit_terms(std::span<const Record> records, const SegmentFit<N>& fit);

/// Value of a term but kReflex, and what one of its coefficient is in SI where motion and force are in these
/// units.
[[nodiscard]] double value_of(Term term, double position, double velocity);
[[nodiscard]] double unit_of(Term term, double force, double position, double velocity);

}  // namespace tonus::spectral
