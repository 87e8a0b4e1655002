#pragma once

#include <optional>

#include "analysis_service/study/figure.hpp"
#include "analysis_service/study/study.hpp"

namespace tonus::study {

/// Fig. 10: spring centres under bias forces, predicted (20) and actual (19), of a subject with a loaded
/// session; none without an unloaded set to predict from.
[[nodiscard]] std::optional<Figure> spring_centre_figure(const Subject& subject);

}  // namespace tonus::study
