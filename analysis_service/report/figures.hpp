#pragma once

#include <vector>

#include "analysis_service/report/figure.hpp"
#include "analysis_service/study/study.hpp"

namespace tonus::report {

/// The paper's figures 3 to 10 by their numbers, and the convergence trace: of the study's first subject who
/// has what the figure needs (Fig. 7: of the second). A figure whose data are not there is left out. Ellipses
/// stand in the workspace at the hand's position, equal axes, m; their radius is the restoring force for a
/// unit displacement, to the scale of the calibration circle; thin dotted lines are their 95 % bands.
[[nodiscard]] std::vector<Figure> figures(const study::Study& study);

}  // namespace tonus::report
