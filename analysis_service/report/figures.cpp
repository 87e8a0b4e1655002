#include "analysis_service/report/figures.hpp"

#include <optional>

#include "analysis_service/report/matrix_figure.hpp"
#include "analysis_service/report/posture_figures.hpp"
#include "analysis_service/report/spring_centre_figure.hpp"
#include "analysis_service/report/trace_figures.hpp"

namespace tonus::report {

using impedance::Hypothesis;

std::vector<Figure> figures(const study::Study& study) {
  std::vector<const study::Subject*> unloaded;
  const study::Subject* loaded = nullptr;
  for (const study::Subject& subject : study.subjects) {
    if (subject.unloaded && !subject.unloaded->conditions.empty()) unloaded.push_back(&subject);
    if (subject.loaded && loaded == nullptr) loaded = &subject;
  }
  std::vector<Figure> all;
  const auto add = [&all](std::optional<Figure> figure) {
    if (figure) all.push_back(std::move(*figure));
  };
  if (!unloaded.empty()) {
    const study::Subject& first = *unloaded.front();
    add(perturbation_figure(first));
    add(matrix_figure(first));
    add(mass_figure(first));
    add(constrained_figure(first));
    add(posture_figure(*unloaded[unloaded.size() > 1 ? 1 : 0]));
    add(hypothesis_figure(first, "figure8", "Fig. 8. Damping identified and reconstructed, one constant",
                          Hypothesis::kSS, Hypothesis::kSD));
    add(hypothesis_figure(first, "figure9", "Fig. 9. Damping identified and reconstructed, three constants",
                          Hypothesis::kMS, Hypothesis::kMD));
  }
  if (loaded != nullptr) add(spring_centre_figure(*loaded));
  if (!unloaded.empty()) add(convergence_figure(*unloaded.front()));
  return all;
}

}  // namespace tonus::report
