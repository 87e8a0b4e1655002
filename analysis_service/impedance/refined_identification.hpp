#pragma once

#include <optional>
#include <span>

#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/refined/identification.hpp"

namespace tonus::impedance {

/// Identifies perturbations by instrumental variables (analysis_service/refined), model (3), with its checks:
/// mean residual along the command with the share that is explained, lag, reflex, hardening, friction, width
/// of the intervals, units. A term counts where it is significant at 1 % over the tests and moves an element
/// of M, B, K beyond its 95 % interval; a lag, also where it exceeds 1 ms.
///
/// Fills the estimate's numbers, checks and reasons from what was found in so many trials, or returns why
/// there are none. Intervals: trial-wise covariance CR2, Student's t with the degrees of freedom of Bell
/// and McCaffrey, element by element. `sigma` is that behind the test functions, `explained` of the trials'
/// mean response there: what a trial scatters is in the intervals.
[[nodiscard]] std::optional<Reason> identify_refined(const refined::Estimate& found, std::size_t trials,
                                                     const Options& options, Estimate& estimate);

/// What method refined finds in trials that are in order and last for the window.
[[nodiscard]] refined::Estimate find_refined(std::span<const Trial* const> trials, const Options& options);

/// The same with what the trials' motion has in common for the command, where none is known. For its tests
/// alone: the mean motion holds a part of the trials' own force, which M, B, K then miss. None: the trials
/// are too few, continuous records, of another model, or without numbers.
[[nodiscard]] std::optional<refined::Estimate> tests_by_mean_motion(std::span<const Trial* const> trials,
                                                                    const Options& options);

/// Widens the intervals of M, B, K of an estimate by method refined, made of these trials, where the residual
/// process alone gives wider ones: 1.96 standard deviations of refined's model_covariance(). The trial-wise
/// covariance of few trials is small also by luck, and a session that ends when intervals are narrow selects
/// that luck; the process is known from every row. Depends on the trials alone, not on when they were looked
/// at. Estimates without numbers and by other methods stay as they are; so do intervals of X0 and ellipses.
void widen_by_process(std::span<const Trial> trials, const Options& options, Estimate& estimate);

}  // namespace tonus::impedance
