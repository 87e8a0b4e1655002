#pragma once

#include <optional>
#include <string>

#include "analysis_service/impedance/diagnostics.hpp"
#include "analysis_service/impedance/identification.hpp"

namespace tonus::impedance {

/// Limits of the checks on what the published methods fit.
inline constexpr double kLeastExplained = 0.8;  ///< Of the force's variation about its mean, each axis.
inline constexpr std::size_t kFewestUnits = 5;  ///< Trials or blocks: with fewer, Student's t exceeds 3.

/// Adds the check, and where it did not pass the reason with its detail.
void add_check(FitTest test, double value, double limit, bool is_passed, Reason reason, std::string detail,
               Estimate& estimate);

/// Sets status and reasons. An estimate that has no checks yet gets those of the published methods: explained
/// share, units, and, where they were examined, the lag of the force and what the model leaves of the mean
/// response. A mass matrix whose off-diagonal elements differ by more than their interval is suspect. A
/// `failure` means undetermined: all numbers are emptied. Otherwise a defect of the data, or a stiffness,
/// mass or (in model (3)) damping whose symmetric part is not positive definite, is suspect.
void conclude(Estimate& estimate, std::optional<Reason> failure, const Diagnosis& diagnosis);

}  // namespace tonus::impedance
