#pragma once

#include <vector>

#include "analysis_service/study/loaded_postures.hpp"
#include "analysis_service/study/study.hpp"

namespace tonus::study {

/// The loaded postures of a subject, by state-variable filtering; empty without a loaded session.
[[nodiscard]] std::vector<LoadedPosture> loaded_of(const Subject& subject);

}  // namespace tonus::study
