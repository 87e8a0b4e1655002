#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "analysis_service/spectral/segment_fit.hpp"

namespace tonus::spectral {

/// Functions of motion that the linear model does not have.
enum class Term : std::uint8_t {
  kFriction,   ///< sign(x')
  kHardening,  ///< x^3
  kDrag,       ///< x' |x'|
  kPosition,   ///< x^2: stiffness that changes along the axis.
};
inline constexpr std::array kTerms{Term::kFriction, Term::kHardening, Term::kDrag, Term::kPosition};

/// One term in the fit beside M, B, K and the lag (equation 13).
struct TermFit {
  Term term = Term::kFriction;
  int force_axis = 0;
  int motion_axis = 0;
  double coefficient = 0.0;  ///< N for friction, N/m^3, N s^2/m^2, N/m^2.
  double standard_error = 0.0;
  double t = 0.0;                 ///< coefficient / standard_error.
  double share = 0.0;             ///< Of the force's root mean square that the term carries.
  double change = 0.0;            ///< Largest change of M, B, K with it, over the largest element of each.
  double stiffness_change = 0.0;  ///< kPosition: of stiffness over two standard deviations of position.
  Eigen::VectorXd impedance;      ///< M, B, K with the term, SI, row by row; of force_axis only, N each.
  Eigen::VectorXd impedance_error;
};

/// Regresses the residual R on each term alone. The displacement that the terms are built from is
/// x^ = x + nx Z^H N^-1 R, the best estimate from both signals: it is independent of R where the model holds,
/// so that the tests keep their level. `records` are those that the fit was made from.
template <int N>
[[nodiscard]] std::vector<TermFit> fit_terms(std::span<const Record> records, const SegmentFit<N>& fit);

}  // namespace tonus::spectral
