#pragma once

#include <string_view>
#include <vector>

#include "services/core/progress.hpp"
#include "services/core/result.hpp"
#include "services/recording/recording.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::formats {

/// The participant that stands for a subject: its label, and what is known of the person.
[[nodiscard]] recording::Participant participant_of(std::string_view subject, const v1::SubjectFacts& facts);

/// An archived session as recordings, the content of a BIDS dataset: one run for each posture (and anew where
/// the rig's description or rate changed within one), with every trial that has samples, whole, in the order
/// of the attempts; a reference contraction stands in the first posture's run, as one of its contractions.
/// Samples that the archive has not are rows that are marked as missing. A trial counts as valid as its
/// verdict says; one without verdict does not.
///
/// With what is known of the subject and of the session as a whole. A note stands in the run during whose
/// trials it was written, at its time by the rig's clock; one that was written between trials, or without a
/// rig, stands in no run (but in the session's JSON).
///
/// Labels: participant from the subject's name, session from the first 8 digits of the id, task from the
/// protocol's name, letters and digits of each. kNotFound: no trial with samples, or no rig description.
/// kInvalidArgument: a description that cannot be converted with.
[[nodiscard]] Result<std::vector<recording::Recording>> recordings_of(store::Store& store,
                                                                      const store::Session& session,
                                                                      const Progress& progress = {});

}  // namespace tonus::formats
