#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis_service/identification/trial_judge.hpp"
#include "analysis_service/impedance/options.hpp"
#include "services/core/result.hpp"
#include "services/recording/dataset.hpp"
#include "services/recording/recording.hpp"

#include <idl/estimate.h>

namespace tonus::identification {

/// A perturbation that was left out, and why.
struct LeftOut {
  std::int64_t trial = 0;
  std::string reason;
};

/// One analysis of one condition of a dataset or an archived session.
struct OfflineEstimate {
  std::string participant;
  std::string session;  ///< Empty: none.
  int run = 1;
  std::string tracking_system;    ///< Of a dataset's run; empty: none.
  std::vector<LeftOut> left_out;  ///< Of this condition.
  v1::Estimate estimate;
};

/// Identifies recordings, each of which is one posture of one session, by every analysis: the same functions
/// on the same rows in the same order as the streaming service, so that a replayed recording and this give
/// the same numbers. Left out are perturbations flagged invalid in the dataset, those that the service's own
/// judge (TrialJudge) refuses by the limits of `judge`, and whatever the conversion refuses. A condition of
/// which every perturbation was left out is there too, undetermined. Runs on all processors; the result is in
/// the order of the recordings and does not depend on them. Errors: kInvalidArgument for a rig that cannot be
/// converted with.
[[nodiscard]] Result<std::vector<OfflineEstimate>> identify_recordings(
    std::span<const recording::Recording> recordings, const std::vector<impedance::Options>& analyses,
    const JudgeChoice& judge = {});

/// What a dataset gave.
struct DatasetEstimates {
  std::vector<OfflineEstimate> estimates;
  std::vector<std::string> left_out;  ///< What the dataset left out, and runs, a line each with the reason.
};

/// The same for every recording of a dataset, each of which is read when its turn comes: no more of them than
/// there are processors are in memory. `force_sign`, where given, is stated for every one
/// (recording::state_force_sign). A run that cannot be read, or whose sample rate does not allow the options,
/// is left out; an error, that of the first one, where none remains.
[[nodiscard]] Result<DatasetEstimates> identify_dataset(const recording::Dataset& dataset,
                                                        const std::vector<impedance::Options>& analyses,
                                                        std::optional<int> force_sign = {},
                                                        const JudgeChoice& judge = {});

}  // namespace tonus::identification
