#include "analysis_service/identification/archived_session.hpp"

#include <map>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "analysis_service/identification/conversion.hpp"
#include "analysis_service/identification/offline_book.hpp"
#include "analysis_service/identification/trial_judge.hpp"
#include "analysis_service/identification/wire.hpp"

namespace tonus::identification {
namespace {

/// The description in force at a time; the first one for what was before it.
const v1::RigDescription& description_at(const archive::Session& session, std::uint64_t received_ns) {
  const auto* found = &session.descriptions.front().value;
  for (const auto& description : session.descriptions) {
    if (description.received_ns <= received_ns) found = &description.value;
  }
  return *found;
}

Result<MeasuredTrial> measured(archive::Store& store, const archive::SessionTrial& trial) {
  MeasuredTrial all;
  all.report = from_wire(trial.outcome->value);
  if (!trial.record || !trial.record->has_samples) return all;
  const auto samples = archive::read_trial_samples(store, trial);
  if (!samples) return samples.error();
  all.rows.reserve(samples->size());
  for (const v1::RigSample& sample : *samples) all.rows.push_back(from_wire(sample));
  return all;
}

/// Why the trial does not count; empty: it does.
std::string defect_of(const archive::SessionTrial& trial, const MeasuredTrial& rows, const RigGeometry& rig) {
  if (trial.verdict) {
    if (trial.verdict->value.is_valid()) return {};
    return trial.verdict->value.detail().empty() ? "judged invalid" : trial.verdict->value.detail();
  }
  const Verdict verdict = TrialJudge{}.judge(rows, &rig);
  return verdict.is_valid ? std::string{} : verdict.detail;
}

Result<void> take(archive::Store& store, const archive::Session& session, const archive::SessionTrial& trial,
                  OfflineBook& book) {
  const TrialReport report = from_wire(trial.outcome->value);
  const auto rig = from_wire(description_at(session, trial.outcome->received_ns));
  if (!rig) return rig.error();
  const auto rows = measured(store, trial);
  if (!rows && rows.error().code != ErrorCode::kDataLoss) return rows.error();
  if (!rows) {
    book.leave_out(report, "gap: " + rows.error().message);
    return {};
  }
  if (auto why = defect_of(trial, *rows, *rig); !why.empty()) {
    book.leave_out(report, std::move(why));
    return {};
  }
  const bool is_recording = report.plan.kind == TrialKind::kRecording;
  const std::size_t onset = is_recording ? 0 : report.onset - report.range.first;
  if (const auto converted = trial_from_rows(frame_of(report), *rig, rows->rows, onset)) {
    book.add(report, *converted);
  } else {
    book.leave_out(report, converted.error().message);
  }
  return {};
}

}  // namespace

Result<std::vector<OfflineEstimate>> identify_session(archive::Store& store, const archive::Session& session,
                                                      const std::vector<impedance::Options>& analyses) {
  if (session.descriptions.empty()) {
    return fail(ErrorCode::kNotFound, fmt::format("session {}: store '{}' has no description of its rig",
                                                  to_hex(session.record.session), store.name()));
  }
  std::map<std::uint32_t, OfflineBook> postures;
  for (const archive::SessionTrial& trial : session.trials) {
    if (!trial.outcome) continue;  // it still runs, or its rig was lost
    const std::uint32_t index = trial.outcome->value.program().posture_index();
    OfflineEstimate owner;
    owner.participant = session.record.subject;
    owner.session = to_hex(session.record.session);
    owner.run = static_cast<int>(index) + 1;
    const auto [book, is_new] = postures.try_emplace(index, analyses, std::move(owner));
    if (auto taken = take(store, session, trial, book->second); !taken) return taken.error();
  }
  const v1::RigDescription& last = session.descriptions.back().value;
  const int axes = last.kind() == v1::RIG_ONE_AXIS ? 1 : 2;
  std::vector<OfflineEstimate> all;
  for (auto& [index, book] : postures) {
    for (auto& estimate : book.identify({last.displacement_unit(), last.force_unit()}, axes))
      all.push_back(std::move(estimate));
  }
  return all;
}

}  // namespace tonus::identification
