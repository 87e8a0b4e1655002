#include "analysis_service/report/loaded_table.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/identification/condition_book.hpp"
#include "analysis_service/report/tables.hpp"
#include "analysis_service/service/wire.hpp"
#include "analysis_service/study/units.hpp"

namespace tonus::report {
namespace {

v1::Estimate wire_of(const study::ConditionAnalysis& condition, const impedance::Estimate& estimate) {
  identification::ConditionEstimate made;
  made.condition = condition.condition;
  made.estimate = estimate;
  return identification::to_wire(made, {});
}

}  // namespace

std::vector<study::LoadedPosture> loaded_of(const study::Subject& subject) {
  std::vector<v1::Estimate> estimates;
  if (!subject.loaded) return {};
  for (const auto& condition : subject.loaded->conditions) {
    if (const auto* e = condition.find()) estimates.push_back(wire_of(condition, *e));
  }
  return study::loaded_postures(estimates);
}

const study::ConditionAnalysis& condition_of(const study::Subject& subject,
                                             const study::LoadedPosture& posture,
                                             const study::LoadedSet& set) {
  const auto& conditions = subject.loaded->conditions;
  return *std::find_if(conditions.begin(), conditions.end(), [&](const study::ConditionAnalysis& c) {
    return c.condition.posture_index == posture.posture_index && c.condition.set == set.set_number;
  });
}

Table loaded_table(const study::Study& study) {
  Table table{
      "loaded",
      "Under bias forces",
      "Spring centre from the posture in mm: predicted from the unloaded stiffness (mean of first and "
      "last set) by (20), actual by the set's own fit ± one standard error, and by the static points "
      "(19), with how many trials came to rest. Modulation: loaded over unloaded.",
      {"subject", "posture", "set", "bias (N)", "predicted (mm)", "actual (mm)", "static (mm)", "K size",
       "K shape", "K turned (deg)", "B size", "B shape", "B turned (deg)",
       "fitting error of the filtered force (N)", "unloaded (N)"},
      {}};
  const auto vector = [](const Eigen::Vector2d& v, double scale) {
    return fmt::format("{:+.2f}, {:+.2f}", scale * v[0], scale * v[1]);
  };
  for (const study::Subject& subject : study.subjects) {
    for (const study::LoadedPosture& posture : loaded_of(subject)) {
      for (const study::LoadedSet& set : posture.sets) {
        std::vector<std::string> row{
            subject.name,
            posture.posture,
            std::to_string(set.set_number),
            vector(set.bias, 1.0),
            vector(set.predicted, study::kMillimetres),
            fmt::format("{:+.2f} ± {:.2f}, {:+.2f} ± {:.2f}", study::kMillimetres * set.actual[0],
                        study::kMillimetres * set.actual_std[0], study::kMillimetres * set.actual[1],
                        study::kMillimetres * set.actual_std[1])};
        const auto& trials = condition_of(subject, posture, set).trials;
        const auto still = impedance::static_stiffness(trials, study::static_options());
        row.push_back(still ? fmt::format("{} ({} of {})", vector(still->X0, study::kMillimetres),
                                          still->points.size(), trials.size())
                            : "–");
        for (const auto& modulation : {set.stiffness, set.damping}) {
          row.push_back(modulation ? fmt::format("{:.2f}", modulation->size_ratio) : "–");
          row.push_back(modulation ? fmt::format("{:.2f}", modulation->shape_ratio) : "–");
          row.push_back(modulation && modulation->has_rotation
                            ? fmt::format("{:+.0f}", study::kDegrees * modulation->rotation)
                            : "–");
        }
        row.push_back(fmt::format("{:.2f}, {:.2f}", set.sigma[0], set.sigma[1]));
        row.push_back(fmt::format("{:.2f}, {:.2f}", posture.sigma_unloaded[0], posture.sigma_unloaded[1]));
        table.rows.push_back(std::move(row));
      }
    }
  }
  return table;
}

}  // namespace tonus::report
