#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "analysis_service/impedance/axes.hpp"
#include "analysis_service/impedance/ellipse_intervals.hpp"
#include "analysis_service/impedance/options.hpp"
#include "analysis_service/impedance/trial.hpp"
#include "services/core/result.hpp"

namespace tonus::impedance {

/// Whether the numbers of an Estimate may be used.
enum class Status : std::uint8_t {
  kUndetermined,  ///< The data do not determine the parameters: there are no numbers.
  kOk,
  kSuspect,  ///< There are numbers, and a reason not to trust them.
};

/// Why an estimate is not ok, or a trial was left out. Each defect of the data has its own.
enum class Reason : std::uint8_t {
  kTooFewTrials,       ///< Undetermined: fewer than two trials (or blocks): no interval can be stated.
  kSingleDirection,    ///< Undetermined: all perturbations act along one line; the plane is not excited.
  kRankDeficient,      ///< Undetermined: the regressors do not have full rank with the margin asked for.
  kNegativeStiffness,  ///< Suspect, whatever R2: Ks has an eigenvalue <= 0 (closed-loop artefact).
  kNegativeMass,       ///< Suspect: Ms has an eigenvalue <= 0.
  kNegativeDamping,    ///< Suspect: Bs has an eigenvalue <= 0.
  kCollinearForce,     ///< Suspect: the force channels carry one signal.
  kForceShifted,       ///< Suspect: a force channel leads or lags the displacement.
  kClippedForce,       ///< Suspect: a force channel stands still at its extreme.
  kShortTrial,         ///< Trial left out: it ends before the window does.
  kForceSign,          ///< Suspect: M, B and K are all negative: the force has the opposite sign.
  kNoCommand,          ///< Undetermined: method refined, and the commanded displacement is not known.
  kTooFewSamples,      ///< Undetermined: the records have too few usable rows.
  kNoMotion,           ///< Undetermined: displacement or force of an axis does not move.
  kTooFewSegments,     ///< Undetermined: no enough segments between the gaps while the input is on.
  kNotCoherent,        ///< Undetermined: no band in which force and motion are coherent on every axis.
  kWide,               ///< Undetermined: an interval is too wide for its matrix.
  kUnexplained,        ///< Suspect, as are the following: the model explains too little of the force.
  kIncoherent,         ///< Force and motion are hardly coherent in the band.
  kHalvesDiffer,       ///< Two halves of the data give different matrices.
  kUnsteady,           ///< Parts of a record scatter more than its noise explains.
  kMisfit,             ///< The response departs from the model in a band.
  kLag,                ///< The lag of the force is at the end of what is searched, or beyond what is allowed.
  kFewUnits,           ///< Too few independent units for an interval.
  kFriction,           ///< A part of the force follows the sign of the velocity, or its signed square.
  kHardening,          ///< A part of the force follows the cube of the displacement.
  kPositionDependent,  ///< Stiffness changes with position.
  kHeldSamples,        ///< A channel repeats its samples, or joins those of a slower rate.
  kReflex,             ///< A part of the force follows the displacement 30 to 60 ms late.
  kUnsettledModel,     ///< Undetermined: the coefficients of a model beyond (3) do not settle.
  kAsymmetricMass,     ///< Suspect: the mass matrix is not symmetric: the force is not that of these axes.
  kAtBound,            ///< Suspect: a parameter stands at the end of what is searched.
  kMethodsDiffer,      ///< Methods refined and state_variable differ by more than their joint intervals.
};

/// What an estimate is judged by; on the wire as FitTest.
enum class FitTest : std::uint8_t {
  kExplainedShare,
  kCoherence,
  kHalves,
  kSteadiness,
  kBands,
  kLag,
  kUnits,
  kFriction,
  kHardening,
  kPosition,
  kReflex,
  kClipping,
  kHeldSamples,
  kCrossCheck,
  kWidth,
};

/// One of them: its value and the limit that it is held against (at least for share, coherence, units; else
/// at most). An estimate is ok where all of its checks passed and it has no reason besides.
struct FitCheck {
  FitTest test = FitTest::kExplainedShare;
  double value = 0.0;  ///< Not finite: could not be computed.
  double limit = 0.0;
  bool is_passed = false;
};

/// Names as files have them: too_few_trials, single_direction, ... ; ok, undetermined, suspect.
[[nodiscard]] std::string_view name_of(Reason reason);
[[nodiscard]] std::string_view name_of(Status status);

/// M (kg), B (N s/m), K (N/m), each axes x axes and not symmetrised, and X0 (m), of (3). B has no columns in
/// model (13), three in (14) (N s2/m2, of x1'^2, x1' x2', x2'^2), and is N s2/m2 in (15).
struct Parameters {
  AxisMatrix M;
  AxisMatrix B;
  AxisMatrix K;
  AxisVector X0;
};

/// A parameter beside M, B, K and X0, with its 95 % interval. Unit: force^force * s^time /
/// displacement^length.
struct ModelParameter {
  std::string name;  ///< "friction_x", "cubic_stiffness", "reflex_stiffness_xy", "reflex_delay", ...
  int force = 1;
  int time = 0;
  int length = 0;
  double value = 0.0;
  double std = 0.0;
  double low = 0.0;
  double high = 0.0;
};

/// A trial that was left out of the fit.
struct RejectedTrial {
  std::uint32_t number = 0;
  Reason reason = Reason::kShortTrial;
};

/// The estimate from all trials pooled, of the rows from the onset to end_time.
struct ConvergencePoint {
  double end_time = 0.0;  ///< s from the onset.
  Parameters value;
};

/// The data of a condition in square-root information form: ||Phi Theta - F||^2 = ||R Theta - Z||^2 +
/// residual. Row order of Theta: x"(axes), velocity terms, x (axes), 1.
struct Information {
  Eigen::MatrixXd R;         ///< Upper triangular, regressors x regressors.
  Eigen::MatrixXd Z;         ///< regressors x axes.
  Eigen::VectorXd residual;  ///< Sum of squared residuals per axis, N^2.
  Eigen::Index samples = 0;
};

/// What is known of the errors of a matrix beside its elements' own intervals.
struct MatrixUncertainty {
  Eigen::MatrixXd covariance;               ///< Of the elements, row by row; empty: not known.
  double freedom = 0.0;                     ///< Degrees of freedom behind it: least of the elements'.
  std::optional<EllipseIntervals> ellipse;  ///< None: one axis, or not known.
  AxisMatrix known_bias;  ///< Of the method, simulated (method_bias.hpp); the intervals carry it. Empty: not.
};

/// Result of identify(): starts as undetermined.
struct Estimate {
  Method method = Method::kStateVariable;
  Model model = Model::kLinear;
  Status status = Status::kUndetermined;
  std::vector<Reason> reasons;            ///< In the order of the enumeration, each once.
  std::map<Reason, std::string> details;  ///< Numbers and limits of some of them, one line each.
  std::vector<FitCheck> checks;
  int axes = 0;
  Parameters value;  ///< All empty while undetermined; so are the next three.
  Parameters std;    ///< One standard deviation of each element, the trial being the independent unit.
  Parameters low;    ///< Lower ends of the 95 % intervals.
  Parameters high;   ///< Upper ends.
  /// Of M, B and K; empty in undetermined.
  struct Uncertainty {
    MatrixUncertainty M;
    MatrixUncertainty B;
    MatrixUncertainty K;
  } uncertainty;
  Eigen::MatrixXd X0_covariance;  ///< m2, axes square; empty: not known.
  Eigen::MatrixXd
      covariance;        ///< Of vec(Theta), column by column: (regressors*axes) square; none in undetermined.
  AxisVector sigma;      ///< N, (16) as root mean square, of the (filtered) force that was fitted.
  AxisVector explained;  ///< Share of that force's variation about its mean that the model explains (R2).
                         ///< Method refined: of the mean response to the command.
  double condition_number =
      0.0;  ///< Of the regressor with columns scaled to unit length; infinite if singular.
  Eigen::Index samples = 0;
  std::vector<std::uint32_t> trials_used;  ///< Ascending.
  std::vector<RejectedTrial> trials_rejected;
  std::size_t units =
      0;  ///< Independent units behind the intervals: trials, or blocks of a continuous record.
  double natural_frequency = 0.0;  ///< Hz, of (8); 0 in the other methods.
  AxisVector force_lag;            ///< s that each force channel lags what fits the displacement best.
  AxisVector force_lag_low;        ///< s, ends of its 95 % interval; empty: not known.
  AxisVector force_lag_high;
  double band_low = 0.0;  ///< Hz, that a spectral fit used; 0 and 0: none was chosen.
  double band_high = 0.0;
  double segment_duration = 0.0;  ///< s, of a spectral fit.
  std::vector<ModelParameter> parameters;
  std::string compared;  ///< Of Model::kAutomatic: what was compared and how it fared; else empty.
  std::vector<ConvergencePoint> trace;
  std::optional<double> settling_time;  ///< s; none: not traced, or not settled before the window's end.
  Information information;
};

/// Identifies one condition (posture, bias, instruction) from its valid trials: M, B, K, X0 of (3) or the
/// model's other parameters, their standard deviations and 95 % intervals, and whether to trust them.
///
/// Method refined: refined_identification.hpp, for perturbations whose commanded displacement is known, and
/// model (3). The others:
///
/// Law: least squares of F on [x" x' x 1] (method, section 4) in square-root information form; trials are
/// taken in ascending number, so that the result does not depend, to the last bit, on the order given.
/// Intervals: the trial is the independent unit (samples within one are correlated): leave-one-trial-out
/// jackknife, Student's t with trials - 1 degrees of freedom. A continuous record is cut into blocks.
/// Errors (kInvalidArgument): options out of limits, trials of different axes, sample period, or numbers that
/// repeat, signals of different lengths, an onset outside the record, perturbations and continuous records in
/// one condition, a method that does not suit them, gaps in a record that a published method is asked for. No
/// trials at all is "undetermined". Pure, thread-safe, allocates.
[[nodiscard]] Result<Estimate> identify(std::span<const Trial> trials, const Options& options);

/// identify() by several methods and models, in their order: the same numbers, but what they share (tuning,
/// diagnosis) is found once.
[[nodiscard]] std::vector<Result<Estimate>> identify_each(std::span<const Trial> trials,
                                                          std::span<const Options> analyses);

}  // namespace tonus::impedance
