#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "analysis_service/spectral/segment_fit.hpp"

namespace tonus::spectral {

/// What is added to M x" + B x' + K x.
enum class Addition : std::uint8_t {
  kNone,
  kFriction,  ///< c sign(x'), axis by axis.
  kCubic,     ///< q x^2 + c x^3 about the record's mean position, axis by axis.
  kReflex,    ///< k x(t - delay) + b x'(t - delay), matrices of the axes, one delay.
};

/// A parameter beside M, B, K and the lag.
struct Parameter {
  enum class Kind : std::uint8_t {
    kFriction,         ///< N.
    kQuadratic,        ///< N/m^2.
    kCubic,            ///< N/m^3.
    kReflexStiffness,  ///< N/m.
    kReflexDamping,    ///< N s/m.
    kReflexDelay,      ///< s.
  };
  Kind kind = Kind::kFriction;
  int force_axis = 0;
  int motion_axis = 0;
  double value = 0.0;
  double error = 0.0;  ///< One standard deviation.
};

/// The linear model fitted to records whose force has lost what the addition explains (equation 15).
template <int N>
struct ExtendedFit {
  SegmentFit<N> fit;
  std::vector<Record> corrected;  ///< That the fit was made from.
  std::vector<Parameter> parameters;
  Eigen::VectorXd variance;  ///< Of M, B, K and the lags with the addition free; scaled as fit.p.
  double gain = 0.0;         ///< Of the logarithm of the likelihood, over the linear model on the same noise.
  double data = 0.0;         ///< Independent real numbers behind the gain.
};

/// Reflex delays that are searched, s.
inline constexpr double kShortestReflex = 0.020;
inline constexpr double kLongestReflex = 0.080;

/// Fits the linear model and an addition by turns: the addition's coefficients by regression of the residual
/// beside M, B, K and lag (equation 13), then the linear model to the force without it, until the
/// coefficients stand still. `linear`: the fit of the same records without the addition; its segment length,
/// band and lag are taken over. Nothing where the fit fails or the coefficients do not settle. `records` are
/// filled().
template <int N>
[[nodiscard]] std::optional<ExtendedFit<N>> fit_extended(std::span<const Record> records,
                                                         const SegmentFit<N>& linear, Addition addition,
                                                         const FitSettings& settings);

}  // namespace tonus::spectral
