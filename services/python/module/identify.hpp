#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis_service/offline/offline.hpp"
#include "analysis_service/offline/request.hpp"
#include "services/contract/rig.hpp"
#include "services/core/result.hpp"

/// Identification of what Python holds: plain arrays, through the functions of the offline identification. No
/// Python.
namespace tonus::python {

/// One trial or record as columns, row-major rows x axes.
struct ArrayTrial {
  std::span<const double> force;         ///< NaN: nothing was measured in this row.
  std::span<const double> displacement;  ///< As long as `force`.
  std::span<const double> commanded;     ///< As long, or empty: not known.
  std::optional<std::int64_t> onset;     ///< Row at which the perturbation starts; none: a continuous record.
};

/// What all of them have in common: one condition.
struct ArrayCondition {
  unsigned axes = 2;
  double rate = 0.0;  ///< Hz.
  contract::RigUnits units;
  double handle_mass = 0.0;      ///< kg on the hand's side of the flexure.
  std::array<double, 2> bias{};  ///< N; not zero: the mean force of the rest counts.
  std::string posture;
};

/// Every analysis of the condition; what the same rows give in a dataset of converted channels, to the last
/// bit. Trials that cannot be used are left out with their reason. kInvalidArgument: arrays whose lengths
/// differ, a rate that is not positive, settings that it does not allow.
[[nodiscard]] Result<std::vector<identification::OfflineEstimate>> identify_arrays(
    const std::vector<ArrayTrial>& trials, const ArrayCondition& condition,
    const identification::Request& request);

/// `{"schema": 1, "conditions": [...]}` as `tonus identify --json` writes it, on one line, and beside it
/// "axes" and "posture_m" (in S), an element for each condition.
[[nodiscard]] std::string results_text(const std::vector<identification::OfflineEstimate>& estimates);
/// The same with `left_out`, a line for each item of the dataset that was left out.
[[nodiscard]] std::string results_text(const identification::DatasetEstimates& found);

}  // namespace tonus::python
