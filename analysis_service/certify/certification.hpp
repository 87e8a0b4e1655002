#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "analysis_service/certify/drawn_session.hpp"
#include "analysis_service/impedance/options.hpp"
#include "analysis_service/impedance/trial.hpp"
#include "services/core/progress.hpp"
#include "services/core/result.hpp"

namespace tonus::certify {

/// What a method is worth over many drawn conditions, of M, B, K and X0 in this order. Errors of M, B, K are
/// shares of the largest element of the true matrix, those of X0 are m. `_error`: one standard error of the
/// simulation itself.
struct MatrixWorth {
  double bias = 0.0;  ///< Of the element with the largest mean error.
  double bias_error = 0.0;
  double rmse = 0.0;        ///< Root mean square over conditions and elements.
  double over_bound = 0.0;  ///< RMSE over the bound, mean over elements; 0 for X0.
  double worst_over_bound = 0.0;
  double coverage = 0.0;  ///< Share of true elements inside the 95 % interval.
  double coverage_error = 0.0;
  double half_width = 0.0;  ///< Mean of the intervals' half-widths, as the errors.
  /// Share of all elements whose estimate is ok and whose interval misses the truth: 5 % where the intervals
  /// hold and nothing is flagged.
  double wrong_and_ok = 0.0;
};

/// Of an ellipse's number: share of the conditions, among those whose interval is determined, in which it
/// holds the true number.
struct EllipseWorth {
  double coverage = 0.0;
  double coverage_error = 0.0;
  double determined = 0.0;  ///< Share of the conditions with numbers whose interval is finite.
};

/// The numbers of an ellipse, in the order of MethodWorth::ellipses.
inline constexpr std::array kEllipseNumbers{"size", "shape", "orientation", "curl"};

struct MethodWorth {
  impedance::Method method = impedance::Method::kStateVariable;
  std::array<MatrixWorth, 4> matrices;
  std::array<std::array<EllipseWorth, 4>, 3> ellipses;  ///< Of M, B, K.
  std::size_t conditions = 0;
  std::size_t undetermined = 0;  ///< Of these, without numbers: in none of the above.
  std::size_t suspect = 0;       ///< Flagged; they count above.
  /// `wrong_and_ok` of K against the stiffness between rest and 5 mm, in which a reflex and hardening count.
  double wrong_and_ok_secant = 0.0;
};

/// One setting, number of trials and rise.
struct Cell {
  Design design;
  Setting setting;
  std::size_t conditions = 300;
  std::uint64_t seed = 1;
};

/// The arms that the model does not describe, by name: none, a reflex of 15 and 40 % of K 40 ms late, slack
/// of 0.3 and 1 mm, hardening of 10 and 30 % at 5 mm.
struct NamedError {
  std::string name;
  ModelError error;
};
[[nodiscard]] const std::vector<NamedError>& model_errors();

/// Simulates the cell's conditions, postures in turn, identifies each by every method and compares with the
/// truth. On all processors; the same numbers for the same seed.
[[nodiscard]] std::vector<MethodWorth> certify(const Cell& cell, const Progress& progress = {});

/// What each method is worth in conditions like a measured one: M, B, K drawn from method refined's estimate
/// and its covariance, the rig's response to the command as fitted, and in each trial what a measured trial,
/// drawn with replacement, has beyond it, with a sign drawn (impedance/method_bias.hpp). RMSE over the bound
/// is 0: the bound needs spectra that are not known. kInvalidArgument: method refined finds no numbers in
/// the trials, which need the command and at least four.
struct Likeness {
  std::size_t conditions = 100;
  std::uint64_t seed = 1;
  double window = 1.0;  ///< s.
};
[[nodiscard]] Result<std::vector<MethodWorth>> certify_like(std::span<const impedance::Trial> measured,
                                                            const Likeness& likeness,
                                                            const Progress& progress = {});

}  // namespace tonus::certify
