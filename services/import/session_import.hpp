#pragma once

#include <functional>
#include <string>
#include <vector>

#include "analysis_service/identification/identification_core.hpp"
#include "services/core/progress.hpp"
#include "services/core/result.hpp"
#include "services/recording/recording.hpp"
#include "services/store/store.hpp"

namespace tonus::session_import {

struct ImportSettings {
  std::string dataset;  ///< How people call it, for the archive.
  std::string software_version;
  std::uint64_t imported_ns = 0;  ///< UTC.
  identification::CoreSettings core{};
  std::string configuration_toml{};  ///< The same settings, as they are archived with the sessions.
};

/// Recordings as archived sessions, one for each participant, session and rig. A session has the plan, the
/// rig description, every perturbation as a trial with its samples, outcome and certificate, and the verdicts
/// and estimates that the identification core makes of them, as if it had just been
/// run.
///
/// A trial's samples are its whole range where the dataset states it (trial_onset_s), else what
/// recording::stretch_of() takes. A perturbation that is flagged invalid becomes a trial that was broken off,
/// with the dataset's reason. Trial numbers become attempts. A recording without posture takes the mean place
/// of the hand before its first perturbation. Sequence numbers begin at 0; stamps are the rows' times.
///
/// The ids follow from the content: the same recordings give the same sessions.
struct ImportedSession {
  store::SessionRecord record;
  store::Batch batch;
};
[[nodiscard]] Result<std::vector<ImportedSession>> sessions_of(
    const std::vector<recording::Recording>& recordings, const ImportSettings& settings,
    const Progress& progress = {});

/// Stores the sessions, each in one step. kAlreadyExists: one already exists, and nothing is stored.
/// kUnavailable: `is_interrupted`, asked after each, said so; those before are stored.
[[nodiscard]] Result<std::vector<store::SessionRecord>> store_sessions(
    store::Store& store, const std::vector<ImportedSession>& sessions,
    const std::function<bool()>& is_interrupted = {});

}  // namespace tonus::session_import
