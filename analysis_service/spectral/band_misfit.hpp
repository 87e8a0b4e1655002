#pragma once

#include <Eigen/Core>

#include "analysis_service/spectral/segment_fit.hpp"

namespace tonus::spectral {

/// How far the response departs from the model, by band (equation 11).
struct BandMisfit {
  double ratio = 0.0;  ///< Mean square of the departures over their variance: about 1 where the model holds.
  double largest = 0.0;  ///< Of the response's magnitude, beyond two standard deviations.
};

inline constexpr int kBandCount = 10;
inline constexpr double kMostRatio = 3.0;
inline constexpr double kSmallMisfit = 0.03;  ///< Of the response: allowed up to kSmallMisfitRatio.
inline constexpr double kSmallMisfitRatio = 10.0;

[[nodiscard]] bool is_acceptable(const BandMisfit& misfit);

template <int N>
[[nodiscard]] BandMisfit misfit_of(const SegmentFit<N>& fit);

/// Variance of M, B, K and the lags from the scatter of the bands' scores in place of the blocks': equal to
/// the inverse Hessian where the model holds, larger where bands disagree. Scaled, of the structural
/// parameters.
template <int N>
[[nodiscard]] Eigen::VectorXd variance_over_bands(const SegmentFit<N>& fit);

/// Two disjoint halves of the segments (equation 12): sqrt(F / F95) of their difference, and the largest
/// relative difference of an element.
struct HalvesDifference {
  double value = 0.0;      ///< In joint 95 % half-widths.
  double threshold = 0.0;  ///< The same for 99.9 %.
  double effect = 0.0;     ///< Largest difference of an element over the largest of its matrix.
};
/// The first half against the second, or the middle half against the ends.
template <int N>
[[nodiscard]] HalvesDifference halves_of(const SegmentFit<N>& fit, bool is_middle_against_ends);

}  // namespace tonus::spectral
