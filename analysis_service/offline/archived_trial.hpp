#pragma once

#include <vector>

#include "analysis_service/identification/measured_trial.hpp"
#include "analysis_service/impedance/trial.hpp"
#include "services/store/archived_trial.hpp"

namespace tonus::identification {

/// An archived trial in the terms of the streaming service.
struct ArchivedTrial {
  MeasuredTrial measured;      ///< Rows that the archive does not have are marked as missing, and counted.
  std::vector<bool> is_there;  ///< For each row: the archive has it.
  store::TrialRig rig;         ///< In force when the trial ended.
};

/// The one way from an archive to what is identified: offline, by the study, and in verification. A trial
/// that never began has no rows. Errors: those of store::rig_in_force(), which says what `force_sign` does,
/// and of store::read_trial_samples(). The trial must have an outcome.
[[nodiscard]] Result<ArchivedTrial> read_archived_trial(store::Store& store, const store::Session& session,
                                                        const store::SessionTrial& trial,
                                                        double force_sign = 1.0);

/// trial_from_rows() for an archived trial: kDataLoss where a row is missing, kNotFound where it has none.
[[nodiscard]] Result<impedance::Trial> convert(const ArchivedTrial& trial);

}  // namespace tonus::identification
