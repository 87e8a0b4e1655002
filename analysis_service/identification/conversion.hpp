#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "analysis_service/identification/measured_trial.hpp"
#include "analysis_service/impedance/trial.hpp"
#include "services/core/result.hpp"
#include "services/mechanics/rig_geometry.hpp"

namespace tonus::identification {

/// What zero force is.
enum class TarePolicy : std::uint8_t {
  kRestBeforeOnset,  ///< Mean force of the rest before the perturbation (method, section 2): unloaded trials.
  kDescriptionOffset,  ///< The offset in the rig's description alone: loaded trials, whose bias force counts.
};

/// What turns rows into a Trial beside the rig's geometry.
struct TrialFrame {
  std::uint32_t number = 0;
  TrialKind kind = TrialKind::kPerturbation;
  ShoulderPose shoulder;
  TarePolicy tare = TarePolicy::kRestBeforeOnset;
  double sample_rate = 0.0;  ///< Hz.
  double rest = 0.5;         ///< s before the onset that are used, at most.
};

[[nodiscard]] TarePolicy tare_of(const TrialPlan& plan);

/// The frame of a reported trial.
[[nodiscard]] TrialFrame frame_of(const TrialReport& report);

/// 1 for a one-axis rig, else 2.
[[nodiscard]] int axes_of(const RigGeometry& rig);

/// Settings of impedance::prepare_trial for a rig and frame.
[[nodiscard]] impedance::Preparation preparation_of(const TrialFrame& frame, const RigGeometry& rig);

/// Rows to endpoint displacement and force (services/mechanics/rig_geometry.hpp), in order.
[[nodiscard]] std::vector<EndpointSample> convert(const RigGeometry& rig, const ShoulderPose& shoulder,
                                                  std::span<const Row> rows);

/// The one way from raw rows to what is identified: the service and the command line both take it, so that a
/// live result and an offline one of the same rows are the same numbers. Of a perturbation: the rest before
/// the onset (at most `frame.rest`) and everything up to the way back. `onset` is an index of `rows`. Of a
/// recording: all rows, `onset` is not looked at; missing rows stay marked in it. Errors: kDataLoss for a
/// missing row of a perturbation, a recording without any row, or one that is not finite; those of
/// impedance::prepare_trial. Pure and thread-safe.
[[nodiscard]] Result<impedance::Trial> trial_from_rows(const TrialFrame& frame, const RigGeometry& rig,
                                                       std::span<const Row> rows, std::size_t onset);

}  // namespace tonus::identification
