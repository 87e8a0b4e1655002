#pragma once

#include <optional>

#include "analysis_service/report/figure.hpp"
#include "analysis_service/study/study.hpp"

/// Figures over time, of the subject's first unloaded posture; none where there is none.
namespace tonus::report {

/// Fig. 3: force and displacement of one perturbation.
[[nodiscard]] std::optional<Figure> perturbation_figure(const study::Subject& subject);
/// The estimate as a function of the end of the fitted window (method, section 4).
[[nodiscard]] std::optional<Figure> convergence_figure(const study::Subject& subject);

}  // namespace tonus::report
