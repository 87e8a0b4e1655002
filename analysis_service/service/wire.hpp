#pragma once

#include <string>
#include <vector>

#include "analysis_service/identification/condition_book.hpp"
#include "analysis_service/identification/measured_trial.hpp"
#include "analysis_service/identification/trial_assembler.hpp"
#include "analysis_service/identification/trial_judge.hpp"
#include "services/contract/rig.hpp"
#include "services/core/result.hpp"
#include "services/mechanics/rig_geometry.hpp"

#include <idl/archive.h>
#include <idl/estimate.h>
#include <idl/rig.h>
#include <idl/trial.h>

/// Where this service's own types meet the wire's. Pure.
namespace tonus::identification {

[[nodiscard]] Row from_wire(const v1::RigSample& wire);

/// Replaces the content of `rows`; the block's rows are those.
[[nodiscard]] RowBlock from_wire(const v1::SampleBlock& wire, std::vector<Row>& rows);

[[nodiscard]] TrialPlan from_wire(const v1::TrialCommand& wire);
[[nodiscard]] TrialReport from_wire(const v1::TrialOutcome& wire);

[[nodiscard]] v1::VerdictReason to_wire(Defect defect);
[[nodiscard]] v1::TrialVerdict to_wire(const TrialReport& report, const Verdict& verdict);
[[nodiscard]] v1::ArchiveResend to_wire(const ResendRequest& request);

using contract::RigUnits;

/// Angles and torques.
[[nodiscard]] inline bool is_rotary(const RigUnits& units) { return units.displacement == "rad"; }

/// Matrices that the model does not have, or that do not fit 2x2 (B_C of model (14), which has three
/// columns), are zero without an ellipse; so is everything of an undetermined condition, and the second axis
/// of a one-axis rig.
[[nodiscard]] v1::Estimate to_wire(const ConditionEstimate& estimate, const RigUnits& units);

/// A matrix of which nothing is known; its elements' covariance, row by row; its ellipse with what is known
/// of its intervals. For what makes estimates beside the service: a prior.
[[nodiscard]] v1::MatrixEstimate unknown_matrix();
void set_covariance(const Eigen::MatrixXd& covariance, v1::MatrixEstimate& wire);
void set_ellipse(const Eigen::Matrix2d& Z, const std::optional<impedance::EllipseIntervals>& intervals,
                 v1::MatrixEstimate& wire);

}  // namespace tonus::identification
