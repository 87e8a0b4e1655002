#pragma once

#include <vector>

#include "services/core/progress.hpp"
#include "services/core/result.hpp"
#include "services/recording/recording.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::formats {

/// An archived session as recordings, the content of a BIDS dataset: one run for each posture (and anew where
/// the rig's description or rate changed within one), with every trial that has samples, whole, in the order
/// of the attempts. Samples that the archive has not are rows that are marked as missing. A trial counts as
/// valid as its verdict says; one without verdict does not.
///
/// Labels: participant from the subject's name, session from the first 8 digits of the id, task from the
/// protocol's name, letters and digits of each. kNotFound: no trial with samples, or no rig description.
/// kInvalidArgument: a description that cannot be converted with.
[[nodiscard]] Result<std::vector<recording::Recording>> recordings_of(store::Store& store,
                                                                      const store::Session& session,
                                                                      const Progress& progress = {});

}  // namespace tonus::formats
