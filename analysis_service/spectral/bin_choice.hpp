#pragma once

#include <Eigen/Core>
#include <vector>

namespace tonus::spectral {

/// Frequencies that may be used, Hz.
struct FrequencyRange {
  double low = 0.0;
  double high = 1e9;
};

inline constexpr double kOverlap = 2.0;  ///< Segments of three quarters overlap that count as one.

/// Bins that are fitted, by index, and the coherence of all.
struct BinChoice {
  std::vector<Eigen::Index> bins;
  Eigen::ArrayXd coherence;  ///< Of every bin: the least canonical one of force and motion, bias taken away.
};

/// Bins that are coherent, strong on every axis and in range, thinned evenly to the most that are fitted
/// (200, of two axes 120). `Y`: by segment, rows F, X2, X1, X0 of N axes each, a column a bin of frequency
/// `w` (rad/s); `active` are the segments that count.
template <int N>
[[nodiscard]] BinChoice choose_bins(const std::vector<Eigen::MatrixXcd>& Y,
                                    const std::vector<std::size_t>& active, const Eigen::ArrayXd& w,
                                    double least_coherence, const FrequencyRange& range);

/// Low quantile over the bins from `first` on of the mean power of a row of Y: the noise of its sensor, where
/// these lie above the band. 0: there are too few.
[[nodiscard]] double noise_floor(const std::vector<Eigen::MatrixXcd>& Y,
                                 const std::vector<std::size_t>& active, int row, Eigen::Index first);

}  // namespace tonus::spectral
