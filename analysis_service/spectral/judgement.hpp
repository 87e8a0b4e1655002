#pragma once

#include <span>

#include "analysis_service/spectral/band_misfit.hpp"
#include "analysis_service/spectral/identification.hpp"
#include "analysis_service/spectral/segment_fit.hpp"

namespace tonus::spectral {

/// What is judged, beside the estimate's own numbers and terms.
template <int N>
struct Judged {
  std::span<const Record> raw;  ///< As given: clipped and held samples are looked for in them.
  const SegmentFit<N>& fit;
  BandMisfit misfit;
  double excited_misfit = 0.0;  ///< Largest misfit over the whole excited band.
  double most_lag = 0.0;        ///< s, that was searched.
};

/// Appends every check to the estimate (README.md, table).
template <int N>
void judge(const Judged<N>& judged, Estimate& estimate);

/// Relative half-width beyond which the noise alone leaves an element undetermined.
inline constexpr double kMostWidth = 0.5;

}  // namespace tonus::spectral
