#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "analysis_service/spectral/extended_fit.hpp"
#include "analysis_service/spectral/nonlinear_terms.hpp"
#include "analysis_service/spectral/record.hpp"

namespace tonus::spectral {

/// What an estimate has to pass to be trusted. In the order in which they are reported.
enum class Test : std::uint8_t {
  kExplainedShare,  ///< Of the force's power in the band, at least.
  kCoherence,       ///< Mean over the band, at least.
  kHalves,          ///< sqrt(F / F95) of two disjoint halves' difference, at most.
  kBands,           ///< Largest departure of the response from the model in a band, relative, at most.
  kLag,             ///< s, magnitude, at most.
  kUnits,           ///< Independent blocks, at least.
  kFriction,   ///< Share of the force that follows the sign of the velocity (or its signed square), at most.
  kHardening,  ///< Share that follows the cube of the displacement, at most.
  kPosition,   ///< Relative change of stiffness over the positions met, at most.
  kReflex,     ///< Share that follows the displacement 30 to 60 ms late, at most.
  kClipping,   ///< Share of samples at a channel's end, at most.
  kHeldSamples,  ///< Share of samples that repeat or only join others, at most.
  kSteadiness,   ///< sqrt of the blocks' scatter over what the noise explains, at most.
  kWidth,        ///< Largest 95 % half-width relative to its matrix, at most.
  kSymmetry,  ///< Two axes: difference of the mass matrix's off-diagonal elements over its largest, at most.
  kAtBound,   ///< Reflex: s from its delay to the nearer end of what is searched, at least.
};

struct Check {
  Test test = Test::kExplainedShare;
  double value = 0.0;
  double limit = 0.0;
  bool is_passed = false;
};

enum class Outcome : std::uint8_t {
  kNone,          ///< No numbers: the records are too short or force and motion are not coherent.
  kUndetermined,  ///< The fit does not determine the matrices.
  kFound,         ///< There are numbers, to be trusted if all checks passed.
};

/// Why there are no numbers.
enum class Shortage : std::uint8_t {
  kNone,
  kTooFewSamples,      ///< Fewer than kFewestRows usable rows.
  kNoMotion,           ///< A channel does not move.
  kTooFewSegments,     ///< No length gives kFewestSegments segments between gaps while the input is on.
  kNotCoherent,        ///< Fewer than 8 bins in which force and motion are coherent on every axis.
  kUnsettled,          ///< The coefficients of the addition do not settle.
  kTooFewFrequencies,  ///< The motion has too few independent frequencies to test the model by.
};

inline constexpr Eigen::Index kFewestRows = 200;
/// Independent frequencies of the motion: two determine M, B, K and the lag, and leave nothing to test them
/// by.
inline constexpr double kFewestFrequencies = 2.2;
inline constexpr double kSegmentsOfLongest =
    5.5;  ///< Of the time with input, over the longest segment tried.

struct Settings {
  double most_lag = 0.02;  ///< s, of force against motion, either way; not less than two samples.
  Addition addition = Addition::kNone;
  /// Of the linear model and those with an addition, the simplest that passes every check; of equally simple
  /// ones the likeliest. The linear one where none passes. `addition` is not looked at.
  bool is_automatic = false;
};

/// One model that an automatic choice looked at.
struct Compared {
  Addition addition = Addition::kNone;
  bool is_found = false;  ///< Its coefficients settled.
  bool is_accepted = false;
  double bic = 0.0;  ///< Bayesian information criterion less that of the linear model; 0 for that one.
};

/// M, B, K (axes x axes) and the lags of the forces with their 95 % half-widths.
struct Estimate {
  Outcome outcome = Outcome::kNone;
  Shortage shortage = Shortage::kNone;
  int axes = 0;
  Eigen::MatrixXd M, B, K;
  Eigen::MatrixXd M_error, B_error, K_error;  ///< Standard errors.
  Eigen::MatrixXd covariance;                 ///< Of M, B, K, row by row, and the lags; SI.
  double t95 = 0.0;                           ///< Half-width over standard error.
  Eigen::VectorXd lag, lag_error;             ///< s; positive: the force comes after the motion.
  double band_low = 0.0, band_high = 0.0;     ///< Hz.
  double segment_duration = 0.0;              ///< s.
  std::size_t segments = 0;
  int blocks = 0;            ///< Independent units behind the intervals.
  double explained = 0.0;    ///< Of the force's power in the band.
  double unaccounted = 0.0;  ///< Share that neither the model explains nor the sensors' noise above the band.
  double coherence = 0.0;    ///< Mean over the band.
  double frequencies = 0.0;  ///< Independent ones of the motion.
  Eigen::VectorXd sigma;     ///< N, root mean square of the residual in the band.
  bool is_part_of_band = false;  ///< The model holds in a part of the excited band only: this one.
  std::vector<Check> checks;
  std::vector<TermFit> terms;
  Addition addition = Addition::kNone;
  std::vector<Parameter> parameters;  ///< Of the addition.
  std::vector<Compared> compared;     ///< Of an automatic choice, in the order of their size; else empty.

  [[nodiscard]] bool is_ok() const;
};

/// Identifies F(t) = M x"(t - d) + B x'(t - d) + K (x(t - d) - x0) from continuous records of one arm or
/// joint, 1 or 2 axes, in the frequency domain (README.md, equations by number): the segment length and the
/// band are chosen from the data, the lag d of each force is fitted, both signals may be noisy, and the
/// result is judged. An addition (friction, cubic stiffness, reflex) is fitted beside M, B, K where asked
/// for, and its model is judged alike; kNone of an outcome where its coefficients do not settle. Records have
/// the same axes and sample period. Pure, thread-safe, allocates.
[[nodiscard]] Estimate identify(std::span<const Record> records, const Settings& settings = {});

}  // namespace tonus::spectral
