#include "analysis_service/offline/archived_session.hpp"

#include <algorithm>
#include <map>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "analysis_service/identification/muscle_judge.hpp"
#include "analysis_service/identification/trial_judge.hpp"
#include "analysis_service/offline/archived_trial.hpp"
#include "analysis_service/offline/offline_book.hpp"
#include "analysis_service/service/muscle_settings.hpp"
#include "analysis_service/service/wire.hpp"

namespace tonus::identification {
namespace {

/// Why the trial does not count; empty: it does. One without a verdict is judged now.
std::string defect_of(const store::SessionTrial& trial, const ArchivedTrial& archived,
                      const TrialJudge& judge, MuscleJudge& muscles) {
  const bool is_contraction = archived.measured.report.plan.kind == TrialKind::kContraction;
  const bool is_rejected = trial.review && trial.review->value.is_rejected();
  if (trial.verdict && (!is_contraction || is_rejected)) return store::why_not_counted(trial);
  Verdict verdict = judge.judge(archived.measured, &archived.rig.geometry);
  muscles.judge(archived.measured, judge.limits(), verdict);
  return verdict.is_valid ? std::string{} : verdict.detail;
}

/// Why the trial's rows are not whole; empty: they are.
std::string gap_in(const Result<ArchivedTrial>& archived) {
  if (!archived) return "gap: " + archived.error().message;
  const MeasuredTrial& measured = archived->measured;
  const bool is_recording = measured.report.plan.kind == TrialKind::kRecording;
  if (measured.missing_rows == 0 || (is_recording && measured.missing_rows < measured.rows.size())) return {};
  return fmt::format("gap: {} of {} samples are missing in the archive", measured.missing_rows,
                     measured.rows.size());
}

Result<void> take(store::Store& store, const store::Session& session, const store::SessionTrial& trial,
                  const TrialJudge& judge, MuscleJudge& muscles, OfflineBook& book) {
  const TrialReport report = from_wire(trial.outcome->value);
  const auto archived = read_archived_trial(store, session, trial);
  if (!archived && archived.error().code != ErrorCode::kDataLoss) return archived.error();
  std::string why = gap_in(archived);
  if (why.empty()) why = defect_of(trial, *archived, judge, muscles);
  if (report.plan.kind == TrialKind::kContraction) return {};  // it enters no estimate
  if (!why.empty()) {
    book.leave_out(report, std::move(why));
    return {};
  }
  if (const auto converted = convert(*archived)) {
    book.add(report, *converted);
  } else {
    book.leave_out(report, converted.error().message);
  }
  return {};
}

}  // namespace

bool is_precision_led(const store::Session& session) {
  return session.state && std::ranges::any_of(session.state->conditions(), [](const auto& condition) {
           return condition.precision_goal() > 0.0;
         });
}

Result<std::vector<OfflineEstimate>> identify_session(store::Store& store, const store::Session& session,
                                                      const std::vector<impedance::Options>& analyses,
                                                      const JudgeChoice& choice) {
  if (session.descriptions.empty()) {
    return fail(ErrorCode::kNotFound, fmt::format("session {}: store '{}' has no description of its rig",
                                                  to_hex(session.record.session), store.name()));
  }
  const v1::RigDescription& last = session.descriptions.back().value;
  const RigUnits units{last.displacement_unit(), last.force_unit()};
  const TrialJudge judge(choice.limits(is_rotary(units)));
  MuscleJudge muscles;
  muscles.begin(muscle_settings_of(session.plan.protocol_toml()));
  std::map<std::uint32_t, OfflineBook> postures;
  for (const store::SessionTrial& trial : session.trials) {
    if (!trial.outcome) continue;  // still running, or its rig was lost
    const std::uint32_t index = trial.outcome->value.program().posture_index();
    OfflineEstimate owner;
    owner.participant = session.record.subject;
    owner.session = to_hex(session.record.session);
    owner.run = static_cast<int>(index) + 1;
    const auto [book, is_new] = postures.try_emplace(index, analyses, std::move(owner));
    if (is_new) book->second.set_precision_led(is_precision_led(session));
    TONUS_TRY(take(store, session, trial, judge, muscles, book->second));
  }
  const int axes = last.kind() == v1::RIG_ONE_AXIS ? 1 : 2;
  std::vector<OfflineEstimate> all;
  for (auto& [index, book] : postures) {
    for (auto& estimate : book.identify(units, axes)) all.push_back(std::move(estimate));
  }
  return all;
}

}  // namespace tonus::identification
