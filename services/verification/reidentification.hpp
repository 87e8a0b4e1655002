#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "analysis_service/identification/identification_core.hpp"
#include "services/core/progress.hpp"
#include "services/store/session_reader.hpp"

#include <idl/estimate.h>
#include <idl/trial.h>

namespace tonus::verification {

/// What the identification service is to be, to be the one that was there.
struct CoreChoice {
  identification::CoreSettings core;
  double force_sign = 1.0;   ///< Of a one-axis rig.
  bool is_archived = false;  ///< From the service's archived configuration; else from the estimates alone.
};

/// The settings of the identification service that served the session: from its archived configuration, the
/// newest; where there is none, methods, models and filters from the published estimates and defaults for the
/// rest (a filter frequency is then tuned to the data).
[[nodiscard]] CoreChoice choose_core(const store::Session& session);

/// What the archived raw messages lead to.
struct Reidentification {
  std::vector<v1::TrialVerdict> verdicts;  ///< By attempt; what was measured, no operator's review.
  std::vector<v1::Estimate> estimates;     ///< As store::newest_estimates orders them.
  std::vector<std::string> remarks;        ///< What went wrong on the way.
};

/// Feeds the session's samples and outcomes through an IdentificationCore, the same code as the service's, on
/// a clock of its own. Trials whose samples are not all there are judged with gaps, as the service would
/// after asking in vain; those that an operator rejected are judged, and left out of every
/// estimate. Errors: the store's, or a rig description that cannot be converted with.
[[nodiscard]] Result<Reidentification> reidentify(store::Store& store, const store::Session& session,
                                                  const CoreChoice& choice, const Progress& progress = {});

/// One estimate anew from exactly the trials that it names, with its own settings; for estimates that were
/// published before all trials had been judged, or whose trials are judged otherwise now. With
/// `is_frequency_given` its natural frequency is a setting, else it is tuned to the data.
[[nodiscard]] Result<v1::Estimate> reidentify_as_published(store::Store& store, const store::Session& session,
                                                           const v1::Estimate& published, double force_sign,
                                                           bool is_frequency_given);

}  // namespace tonus::verification
