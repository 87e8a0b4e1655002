#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "analysis_service/spectral/record.hpp"

namespace tonus::spectral {

/// Where a segment begins.
struct Segment {
  std::size_t record = 0;
  Eigen::Index first = 0;
};

/// Bins of a transform that are used: w = 2 pi bin / (length sample_period).
struct Bins {
  Eigen::Index first = 0;
  Eigen::Index end = 0;
};

/// Segments of `length` rows, a quarter of it apart, that hold no missing row.
[[nodiscard]] std::vector<Segment> segments_of(std::span<const Record> records, Eigen::Index length);

/// Windowed spectra of a segment (equations 1 to 3): rows F, X2, X1, X0, each of axes() rows; a column a bin.
/// With h = sin^4, which vanishes with its first three derivatives at the ends, X1 and X2 are the spectra of
/// h x' and h x" from x alone: no difference, no leakage, no initial state. An offset reaches bins 0 to 2.
[[nodiscard]] std::vector<Eigen::MatrixXcd> windowed_spectra(std::span<const Record> records,
                                                             std::span<const Segment> segments,
                                                             Eigen::Index length, const Bins& bins);

/// Spectra of h s for further signals: by segment, a row a signal. `signals` by record, a column each.
[[nodiscard]] std::vector<Eigen::MatrixXcd> windowed_spectra(std::span<const Eigen::MatrixXd> signals,
                                                             std::span<const Segment> segments,
                                                             Eigen::Index length,
                                                             std::span<const Eigen::Index> bins);

}  // namespace tonus::spectral
