#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "analysis_service/refined/trial_covariance.hpp"
#include "analysis_service/refined/weak_form.hpp"
#include "analysis_service/refined/weighted_fit.hpp"

namespace tonus::refined {

/// What else than M, B, K the force may hold.
enum class Alternative : std::uint8_t {
  kReflex,     ///< The velocity of 40 ms ago.
  kHardening,  ///< x |x|^2.
  kFriction,   ///< The direction of the velocity.
  kSlack,      ///< The direction of the displacement: what a slack takes from the spring's force.
};

/// Test of one of them (9).
struct AlternativeTest {
  Alternative alternative = Alternative::kReflex;
  double p = 1.0;       ///< Of no such term: chi-squared, by the residual process.
  double effect = 0.0;  ///< Largest change of an element of M, B, K by the term, in 95 % half-widths.
  double share = 0.0;   ///< The same over the largest element of its matrix.
  /// Of theta by the term, of its M, B, K of slow motion: of a reflex b x'(t - d), b counts as B and -d b as
  /// M. Empty: the motion has no such term.
  Eigen::MatrixXd change{};
};

/// Whether the force is late (10): F(t) = Z x(t - lag), axis by axis.
struct LagTest {
  double p = 1.0;       ///< Of no lag: chi-squared, by the residual process.
  Eigen::VectorXd lag;  ///< s, positive where the force is late, axes.
  Eigen::VectorXd std;
  double effect = 0.0;  ///< As of an alternative.
  double share = 0.0;
  double sample_period = 0.0;  ///< s.
};

/// Adds each alternative, computed from the motion that the command predicts (rows x axes a trial) and so its
/// own instrument, to the fit.
[[nodiscard]] std::vector<AlternativeTest> test_alternatives(const WeightedFit& fit,
                                                             const TrialCovariance& covariance,
                                                             const std::vector<Eigen::MatrixXd>& predicted,
                                                             const WeakForm& weak, double sample_period);

/// Adds the lag, computed from the motion that the command predicts, to the fit.
[[nodiscard]] LagTest test_lag(const WeightedFit& fit, const TrialCovariance& covariance,
                               const std::vector<Eigen::MatrixXd>& predicted, const WeakForm& weak,
                               double sample_period);

/// The mean residual along the command against the trials' scatter about it (11): whether (1) holds at all.
struct MisfitTest {
  double p = 1.0;             ///< Of (1): Fisher's F. 1 where the trials are too few to say.
  double share = 0.0;         ///< Of the force's mean response, beyond what noise gives; root of squares.
  Eigen::VectorXd explained;  ///< Share of the mean response's variation that (1) explains, axes.
};

/// `weights`: of each trial (rows) in the mean response along each axis, W = U (U'U)^-1.
[[nodiscard]] MisfitTest test_misfit(const WeightedFit& fit, const std::vector<TrialRows>& trials,
                                     const Eigen::MatrixXd& weights);

}  // namespace tonus::refined
