#pragma once

#include <vector>

#include "analysis_service/study/loaded_postures.hpp"
#include "analysis_service/study/study.hpp"

namespace tonus::report {

/// The loaded postures of a subject, by state-variable filtering; empty without a loaded session.
[[nodiscard]] std::vector<study::LoadedPosture> loaded_of(const study::Subject& subject);

/// What a set of loaded_of(subject) was made from.
[[nodiscard]] const study::ConditionAnalysis& condition_of(const study::Subject& subject,
                                                           const study::LoadedPosture& posture,
                                                           const study::LoadedSet& set);

}  // namespace tonus::report
