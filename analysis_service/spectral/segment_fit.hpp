#pragma once

#include <optional>
#include <span>
#include <vector>

#include "analysis_service/spectral/bin_choice.hpp"
#include "analysis_service/spectral/likelihood.hpp"
#include "analysis_service/spectral/windowed_spectra.hpp"

namespace tonus::spectral {

/// The model fitted to records cut into segments of one length.
template <int N>
struct SegmentFit {
  using Model = Likelihood<N>;
  using Vector = typename Model::Vector;

  Eigen::Index length = 0;          ///< Rows of a segment.
  std::vector<Segment> segments;    ///< Those in which the input is active.
  std::vector<Eigen::Index> bins;   ///< That are fitted.
  Eigen::ArrayXd w;                 ///< rad/s, of the bins.
  Eigen::ArrayXd coherence;         ///< Of the bins: the least canonical one of force and motion.
  std::vector<Eigen::MatrixXcd> Y;  ///< By segment: (F, X2, X1, X0) scaled, at the bins.
  std::vector<int> block_of;        ///< By segment.
  Model likelihood{Eigen::ArrayXd(), 1.0};
  typename Model::Data all;                   ///< Moments of all segments.
  std::vector<typename Model::Data> without;  ///< Of all but one block.
  std::vector<typename Model::Data> only;     ///< Of each block alone.
  Vector p = Vector::Zero();                  ///< Parameters, scaled.
  Vector unit = Vector::Ones();               ///< What one of each structural parameter is in SI.
  double w_unit = 1.0;                        ///< rad/s, of scaled w.
  Eigen::Matrix<double, N, 1> force_unit;
  Eigen::Matrix<double, N, 1> displacement_unit;
  /// Power of each scaled signal above the band, where only the sensors' noise is left; 0: no such bins.
  Eigen::Matrix<double, N, 1> force_floor = Eigen::Matrix<double, N, 1>::Zero();
  Eigen::Matrix<double, N, 1> displacement_floor = Eigen::Matrix<double, N, 1>::Zero();
  Eigen::VectorXd lead;  ///< s by which the forces were advanced before.
  typename Model::Hessian inverse_hessian;
  Eigen::MatrixXd shifts;      ///< By block: change of p without it, about their mean.
  Eigen::MatrixXd covariance;  ///< Of the structural parameters, scaled.
  double variation = 0.0;      ///< Largest jackknife variance of an element over that of the inverse Hessian.
  Eigen::VectorXd relative_width;  ///< 95 % half-widths of M, B, K over the largest element of each.
  double score = 0.0;              ///< Sum of the logarithms of these: less is better.

  [[nodiscard]] int blocks() const { return static_cast<int>(only.size()); }
  /// Largest element of M, B or K that element `i` of p belongs to, scaled.
  [[nodiscard]] double largest_beside(int i) const {
    return p.segment(i / (N * N) * (N * N), N * N).cwiseAbs().maxCoeff();
  }
};

struct FitSettings {
  double most_lag = 0.02;        ///< s, of force against motion.
  double least_coherence = 0.5;  ///< Of a bin that is fitted.
  FrequencyRange range;
  bool is_lag_known = false;  ///< The records are aligned already: the lag starts at 0.
  Eigen::VectorXd start;      ///< Parameters of a similar fit, as start_from() gives them; empty: none.
};

inline constexpr std::size_t kFewestSegments = 18;
inline constexpr int kMostBlocks = 15;
inline constexpr double kBinCorrelation = 2.63;  ///< Neighbouring bins of sin^4 that count as one.

/// A fit's parameters in SI, the noises' laws against ln w of w in rad/s: a start for a fit of records that
/// differ little, or in their lag.
template <int N>
[[nodiscard]] Eigen::VectorXd start_from(const SegmentFit<N>& fit);

/// Nothing where fewer than kFewestSegments segments are active or fewer than 8 bins are coherent.
/// `lead` is only noted. Records are filled() and of N axes and one sample period.
template <int N>
[[nodiscard]] std::optional<SegmentFit<N>> fit_segments(std::span<const Record> records, Eigen::Index length,
                                                        const FitSettings& settings,
                                                        const Eigen::VectorXd& lead);

/// How many independent frequencies the motion has on its poorest axis: n^2 / sum |C_kl|^2 of the n bins'
/// correlations C over the segments. A sine counts as one, however many bins its window spreads it over;
/// noise as many as its bins over kBinCorrelation, or as the segments that are independent.
template <int N>
[[nodiscard]] double independent_frequencies(const SegmentFit<N>& fit);

extern template Eigen::VectorXd start_from<1>(const SegmentFit<1>&);
extern template Eigen::VectorXd start_from<2>(const SegmentFit<2>&);
extern template double independent_frequencies<1>(const SegmentFit<1>&);
extern template double independent_frequencies<2>(const SegmentFit<2>&);
extern template std::optional<SegmentFit<1>> fit_segments<1>(std::span<const Record>, Eigen::Index,
                                                             const FitSettings&, const Eigen::VectorXd&);
extern template std::optional<SegmentFit<2>> fit_segments<2>(std::span<const Record>, Eigen::Index,
                                                             const FitSettings&, const Eigen::VectorXd&);

}  // namespace tonus::spectral
