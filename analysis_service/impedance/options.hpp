#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "services/core/result.hpp"

namespace tonus::impedance {

/// How a condition is identified: the published methods to obtain the derivatives of the displacement
/// (method, section 3), the one beyond them for perturbations, and the one for continuous records.
enum class Method : std::uint8_t {
  kLowpass,        ///< Zero-phase Butterworth, then central differences.
  kOptimal,        ///< Optimally regularised Fourier series.
  kStateVariable,  ///< T(s) of (8) on displacement and force; the one that runs sample by sample.
  kRefined,        ///< Perturbations only: instrumental variables (analysis_service/refined).
  kSpectral,       ///< Continuous records only: in the frequency domain (analysis_service/spectral).
};

/// Models of the force (method, section 4), by equation number.
enum class Model : std::uint8_t {
  kLinear,                 ///< (3)  M X" + B X' + K (X - X0)
  kNoDamping,              ///< (13) M X" + K (X - X0)
  kCoriolis,               ///< (14) M X" + B_C [x1'^2, x1' x2', x2'^2]' + K (X - X0)
  kSquaredVelocity,        ///< (15) M X" + B [x1'^2, x2'^2]' + K (X - X0)
  kSignedSquaredVelocity,  ///< (15) with x' |x'| for x'^2.
  kFriction,               ///< Method spectral: (3) and c sign(x'), axis by axis.
  kCubic,                  ///< Method spectral: (3) and q x^2 + c x^3, axis by axis.
  kReflex,                 ///< Method spectral: (3) and k x(t - delay) + b x'(t - delay).
  kAutomatic,  ///< Method spectral: the simplest of linear, friction, cubic, reflex that passes every check.
};

/// The published ones, which perturbations are identified by.
inline constexpr Method kMethods[] = {Method::kLowpass, Method::kOptimal, Method::kStateVariable};
inline constexpr Method kPerturbationMethods[] = {Method::kLowpass, Method::kOptimal, Method::kStateVariable,
                                                  Method::kRefined};
inline constexpr Method kRecordMethods[] = {Method::kLowpass, Method::kOptimal, Method::kStateVariable,
                                            Method::kSpectral};
inline constexpr Method kEveryMethod[] = {Method::kLowpass, Method::kOptimal, Method::kStateVariable,
                                          Method::kRefined, Method::kSpectral};
inline constexpr Model kModels[] = {Model::kLinear, Model::kNoDamping, Model::kCoriolis,
                                    Model::kSquaredVelocity, Model::kSignedSquaredVelocity};
inline constexpr Model kRecordModels[] = {Model::kLinear, Model::kFriction, Model::kCubic, Model::kReflex,
                                          Model::kAutomatic};

/// Names as files and the command line have them: lowpass, optimal, state_variable, refined, spectral;
/// linear, no_damping, coriolis, squared_velocity, signed_squared_velocity, friction, cubic, reflex, auto.
[[nodiscard]] std::string_view name_of(Method method);
[[nodiscard]] std::string_view name_of(Model model);
[[nodiscard]] Result<Method> method_named(std::string_view name);
[[nodiscard]] Result<Model> model_named(std::string_view name);

/// Whether method spectral has the model; whether the published methods have it.
[[nodiscard]] bool is_record_model(Model model);
[[nodiscard]] bool is_published_model(Model model);

/// How a condition is identified. The defaults are the published settings.
struct Options {
  Method method = Method::kStateVariable;    ///< Of perturbations.
  Method record_method = Method::kSpectral;  ///< Of continuous records; the published ones are biased there.
  Model model = Model::kLinear;
  double window = 1.0;   ///< s from the onset that are fitted, more than 0.
  double cutoff = 10.0;  ///< Hz, low-pass; also smooths the velocities of models (14), (15) in every method.
  bool is_force_filtered = false;           ///< lowpass only: the force through the same filter.
  std::optional<double> natural_frequency;  ///< Hz, wn/(2 pi) of (8); none: tuned to the data (tuning.hpp).
  double damping_ratio = 0.1;               ///< zeta of (8), in (0, 1].
  double block = 2.0;                       ///< s, length of the blocks that a continuous record is cut into.
  double rank_margin = 1e-6;     ///< Least inverse condition number that counts as full rank, in (0, 1).
  double settling_share = 0.08;  ///< Of the largest element of each matrix: what counts as settled.
  bool has_trace = true;         ///< Computes the convergence trace.
};

/// Whether the method identifies perturbations, or continuous records.
[[nodiscard]] bool suits(Method method, bool is_record);
/// Whether the method identifies perturbations by the model: refined by (3) alone.
[[nodiscard]] bool has_model(Method method, Model model);

/// "auto", the default: state_variable for perturbations, spectral for continuous records; a name: that
/// method for both; refined: for perturbations.
inline constexpr std::string_view kAutomatic = "auto";
[[nodiscard]] Result<Options> with_method(Options options, std::string_view name);

/// The options by every method; each is for the data that it suits.
[[nodiscard]] std::vector<Options> by_every_method(const Options& options);

/// Refuses options outside the limits stated at their fields, for data of this sample period (s).
[[nodiscard]] Result<void> validate(const Options& options, double sample_period);

}  // namespace tonus::impedance
