#pragma once

#include <vector>

#include "analysis_service/study/loaded_postures.hpp"
#include "analysis_service/study/study.hpp"

namespace tonus::study {

/// The loaded postures of a subject, by state-variable filtering; empty without a loaded session.
[[nodiscard]] std::vector<LoadedPosture> loaded_of(const Subject& subject);

/// What a set of loaded_of(subject) was made from.
[[nodiscard]] const ConditionAnalysis& condition_of(const Subject& subject, const LoadedPosture& posture,
                                                    const LoadedSet& set);

}  // namespace tonus::study
