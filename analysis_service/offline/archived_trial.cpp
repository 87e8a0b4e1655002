#include "analysis_service/offline/archived_trial.hpp"

#include <spdlog/fmt/fmt.h>

#include "analysis_service/identification/conversion.hpp"
#include "analysis_service/service/wire.hpp"

namespace tonus::identification {

Result<ArchivedTrial> read_archived_trial(store::Store& store, const store::Session& session,
                                          const store::SessionTrial& trial, double force_sign) {
  ArchivedTrial archived;
  TONUS_TRY_ASSIGN(archived.rig, store::rig_in_force(session, trial, force_sign));
  archived.measured.report = from_wire(trial.outcome->value);
  if (!trial.record || !trial.record->has_samples) return archived;
  TONUS_TRY_ASSIGN(auto found, store::read_trial_samples(store, trial));
  archived.measured.rows.reserve(found.samples.size());
  for (const v1::RigSample& sample : found.samples) archived.measured.rows.push_back(from_wire(sample));
  archived.measured.missing_rows = found.absent;
  archived.is_there = std::move(found.is_there);
  TONUS_TRY_ASSIGN(archived.measured.auxiliary,
                   store::read_trial_auxiliary(store, trial, archived.rig.description));
  return archived;
}

Result<impedance::Trial> convert(const ArchivedTrial& trial) {
  const TrialReport& report = trial.measured.report;
  if (trial.measured.rows.empty())
    return fail(ErrorCode::kNotFound, fmt::format("trial {}: has no samples", report.plan.attempt));
  const bool is_perturbation = report.plan.kind == TrialKind::kPerturbation;
  const std::size_t onset = !is_perturbation ? 0 : report.onset - report.range.first;
  return trial_from_rows(frame_of(report), trial.rig.geometry, trial.measured.rows, onset);
}

}  // namespace tonus::identification
