#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "analysis_service/offline/offline.hpp"
#include "services/core/result.hpp"

namespace tonus::identification {

/// What was known of a subject before: the results of an earlier session, or of a cohort.
struct PriorChoice {
  std::filesystem::path results;  ///< File of `tonus identify --json` or `tonus show --json`.
  /// How much the same subject's impedance may have changed since, one standard deviation as a share of each
  /// matrix's largest element. Several results of one condition (a cohort) state their own scatter instead.
  double change = 0.1;
};

/// Behind each estimate that the prior has results for (same posture, bias, method, model linear, same axes;
/// none of them undetermined or itself combined), a second one: M, B and K combined with them
/// (impedance/belief.hpp), X0, status, reasons and checks as they are. Its `prior` names the file, how many
/// results it stands for, and by how much the data differ from it.
/// kInvalidArgument: the file is not such a file, or has a result for none of the estimates.
[[nodiscard]] Result<std::vector<OfflineEstimate>> with_prior(std::vector<OfflineEstimate> estimates,
                                                              const PriorChoice& choice);

}  // namespace tonus::identification
