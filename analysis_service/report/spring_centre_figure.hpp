#pragma once

#include <optional>

#include "analysis_service/report/figure.hpp"
#include "analysis_service/study/study.hpp"

namespace tonus::report {

/// Fig. 10: spring centres under bias forces, predicted (20) and actual (19), of a subject with a loaded
/// session; none without an unloaded set to predict from.
[[nodiscard]] std::optional<Figure> spring_centre_figure(const study::Subject& subject);

}  // namespace tonus::report
