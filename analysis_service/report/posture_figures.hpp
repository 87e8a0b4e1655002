#pragma once

#include <optional>

#include "analysis_service/impedance/joint_space.hpp"
#include "analysis_service/report/figure.hpp"
#include "analysis_service/study/study.hpp"

/// Ellipses in the workspace at a subject's unloaded postures, by state-variable filtering; none where
/// something that they need is missing.
namespace tonus::report {

/// Fig. 5: identified mass and that of two cylinders with the link masses of Table I.
[[nodiscard]] std::optional<Figure> mass_figure(const study::Subject& subject);
/// Fig. 6: damping, free and with the mass held at that of Fig. 5.
[[nodiscard]] std::optional<Figure> constrained_figure(const study::Subject& subject);
/// Fig. 7: mass, damping and stiffness.
[[nodiscard]] std::optional<Figure> posture_figure(const study::Subject& subject);
/// Figs. 8 and 9: damping as identified, and as two hypotheses make it from stiffness and inertia.
[[nodiscard]] std::optional<Figure> hypothesis_figure(const study::Subject& subject, const char* id,
                                                      const char* title, impedance::Hypothesis first,
                                                      impedance::Hypothesis second);

}  // namespace tonus::report
