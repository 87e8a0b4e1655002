#pragma once

#include <vector>

#include "analysis_service/identification/trial_judge.hpp"
#include "analysis_service/offline/offline.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::identification {

/// Whether its conditions ended by their estimates (`stop_when`), as its scheduler said.
[[nodiscard]] bool is_precision_led(const store::Session& session);

/// Identifies an archived session by every analysis: the raw rows as archived, through the functions of the
/// streaming service in its order, so that its own analysis comes out with the numbers that it published. A
/// trial counts where its archived verdict says so; one without a verdict is judged now, by `judge`. The
/// others are left out with their reason, as are trials whose rows the archive does not have whole.
/// Participant: the session's subject; session: its id, run: the posture's place in the plan. Errors: those
/// of reading the store; kNotFound: it has no description of the rig.
[[nodiscard]] Result<std::vector<OfflineEstimate>> identify_session(
    store::Store& store, const store::Session& session, const std::vector<impedance::Options>& analyses,
    const JudgeChoice& judge = {});

}  // namespace tonus::identification
