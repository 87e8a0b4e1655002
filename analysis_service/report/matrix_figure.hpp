#pragma once

#include <optional>

#include "analysis_service/report/figure.hpp"
#include "analysis_service/study/study.hpp"

namespace tonus::report {

/// Fig. 4: the stiffness of the subject's first unloaded posture as an ellipse, the locus of the restoring
/// force for a unit displacement turned through 360 deg, with one displacement off the axes and its force.
/// None without an estimate or an ellipse.
[[nodiscard]] std::optional<Figure> matrix_figure(const study::Subject& subject);

}  // namespace tonus::report
