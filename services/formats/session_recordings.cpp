#include "services/formats/session_recordings.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <spdlog/fmt/fmt.h>

#include "services/bus/typed.hpp"
#include "services/contract/rig.hpp"
#include "services/contract/subject.hpp"
#include "services/recording/file_name.hpp"
#include "services/store/archived_trial.hpp"

namespace tonus::formats {
namespace {

using recording::Recording;
using store::Session;
using store::SessionTrial;

std::string label_or(std::string_view name, const char* fallback) {
  std::string label = recording::to_label(name);
  return label.empty() ? fallback : label;
}

std::string participant_label(std::string_view subject) {
  if (subject.starts_with("sub-")) subject.remove_prefix(4);
  return "sub-" + label_or(subject, "unknown");
}

std::optional<double> known(double value) {
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

}  // namespace

recording::Participant participant_of(std::string_view subject, const v1::SubjectFacts& facts) {
  recording::Participant participant;
  participant.id = participant_label(subject);
  participant.age = known(facts.age_years());
  participant.is_age_or_more = participant.age && *participant.age >= contract::kAgeMost;
  participant.sex = facts.sex();
  participant.handedness = facts.handedness();
  participant.measured_arm = facts.measured_arm();
  participant.height_m = known(facts.height_m());
  participant.weight_kg = known(facts.weight_kg());
  participant.upper_arm_m = known(facts.link_lengths_m()[0]);
  participant.forearm_m = known(facts.link_lengths_m()[1]);
  participant.upper_arm_circumference_m = known(facts.circumferences_m()[0]);
  participant.forearm_circumference_m = known(facts.circumferences_m()[1]);
  participant.shoulder_x_m = known(facts.shoulder_m()[0]);
  participant.shoulder_y_m = known(facts.shoulder_m()[1]);
  return participant;
}

namespace {

/// A run without rows, for trials like this one.
Recording new_run(const Session& session, const SessionTrial& trial, const store::TrialRig& rig, int run) {
  const auto& outcome = trial.outcome->value;
  const auto& program = outcome.program();
  Recording record;
  record.participant = participant_of(session.record.subject, session.plan.subject_facts());
  record.session = "ses-" + to_hex(session.record.session).substr(0, 8);
  record.session_facts = {session.record.started_at, session.plan.operator_name(), session.plan.study(),
                          session.plan.is_pilot()};
  record.task = label_or(session.record.protocol_name, "posture");
  record.posture = program.posture();
  record.acquisition = recording::to_label(program.posture());
  record.posture_position = Eigen::Vector2d(program.posture_m()[0], program.posture_m()[1]);
  record.run = run;
  record.sampling_frequency = outcome.sample_rate_Hz();
  record.rig = rig.geometry;
  record.is_raw = rig.geometry.kind == RigKind::kTwoLink;
  record.shoulder = rig.shoulder;
  record.displacement_unit = rig.description.displacement_unit();
  record.force_unit = rig.description.force_unit();
  return record;
}

recording::PerturbationEvent event_of(const SessionTrial& trial, std::size_t rows_before, double rate) {
  const auto& outcome = trial.outcome->value;
  const auto& program = outcome.program();
  recording::PerturbationEvent event;
  const std::uint64_t rows = trial.record->range().count();
  const bool has_onset = outcome.onset_sequence() >= outcome.first_sequence() &&
                         outcome.onset_sequence() <= outcome.last_sequence();
  const std::uint64_t onset = has_onset ? outcome.onset_sequence() - outcome.first_sequence() : rows - 1;
  const double longest = static_cast<double>(rows - onset) / rate;
  event.onset_s = static_cast<double>(rows_before + onset) / rate;
  event.duration_s = has_onset ? std::min(program.hold_s(), longest) : 0.0;
  event.trial = program.attempt();
  if (program.kind() != v1::TRIAL_CONTRACTION) event.set = program.set_number();
  if (program.kind() == v1::TRIAL_RECORDING) event.duration_s = longest;
  if (program.kind() == v1::TRIAL_PERTURBATION) {
    event.direction_deg = program.direction_deg();
    event.amplitude_m = program.amplitude_m();
    event.rise_time_s = program.rise_time_s();
  }
  event.bias_N = program.bias_N();
  event.reason = store::why_not_counted(trial);
  event.is_valid = event.reason.empty();
  event.instruction = program.instruction();
  event.bias_hold_s = program.bias_hold_s();
  event.bias_threshold_N = program.bias_threshold_N();
  event.trial_onset_s = static_cast<double>(rows_before) / rate;
  event.trial_duration_s = static_cast<double>(rows) / rate;
  return event;
}

/// The notes that were written while the trial's samples were taken.
void append_notes(const Session& session, const SessionTrial& trial, const store::TrialSamples& found,
                  Recording& record) {
  const auto is_measured = [](const v1::RigSample& s) { return !contract::flags_of(s).is_missing; };
  const auto first = std::ranges::find_if(found.samples, is_measured);
  if (first == found.samples.end()) return;
  const auto last = std::find_if(found.samples.rbegin(), found.samples.rend(), is_measured);
  for (const auto& arrival : session.notes) {
    const v1::SessionNote& note = arrival.value;
    if (!note.has_rig_clock() || note.epoch() != trial.outcome->value.epoch()) continue;
    if (note.rig_clock_ns() < first->acquisition_ns() || note.rig_clock_ns() > last->acquisition_ns())
      continue;
    const auto row = std::ranges::find_if(found.samples, [&](const v1::RigSample& s) {
      return is_measured(s) && s.acquisition_ns() >= note.rig_clock_ns();
    });
    const auto rows_before = record.rows.size() + static_cast<std::size_t>(row - found.samples.begin());
    recording::NoteEvent event{static_cast<double>(rows_before) / record.sampling_frequency,
                               note.kind(),
                               note.text(),
                               note.written_by(),
                               {}};
    if (const auto attempt = store::attempt_of(session, note); attempt > 0) event.trial = attempt;
    record.notes.push_back(std::move(event));
  }
  std::ranges::stable_sort(record.notes, {}, &recording::NoteEvent::onset_s);
}

void append(const SessionTrial& trial, const store::TrialSamples& found, Recording& record) {
  const bool is_contraction = trial.outcome->value.program().kind() == v1::TRIAL_CONTRACTION;
  (is_contraction ? record.contractions : record.events)
      .push_back(event_of(trial, record.rows.size(), record.sampling_frequency));
  for (const v1::RigSample& sample : found.samples) {
    recording::Row row;
    row.is_missing = contract::flags_of(sample).is_missing;
    row.raw.acquisition_ns = recording::row_time_ns(record, record.rows.size());
    if (!row.is_missing) {
      row.raw.encoder_count = sample.encoder_count();
      row.raw.force_V = sample.force_V();
    }
    record.rows.push_back(row);
    record.commanded.push_back(row.is_missing ? recording::kNoCommand : sample.commanded_m());
    record.phases.push_back(std::min<std::uint8_t>(sample.phase(), v1::PHASE_SAFE));
  }
}

/// The rig's other channels during the trial, behind what the run has of them.
Result<void> append_auxiliary(store::Store& store, const SessionTrial& trial, const store::TrialRig& rig,
                              Recording& record) {
  TONUS_TRY_ASSIGN(auto series, store::read_trial_auxiliary(store, trial, rig.description));
  if (record.auxiliary.empty()) {
    record.auxiliary = std::move(series);
    return {};
  }
  for (std::size_t i = 0; i < series.size(); ++i) {
    auto& values = record.auxiliary[i].values;
    values.insert(values.end(), series[i].values.begin(), series[i].values.end());
  }
  return {};
}

/// What must be the same for trials to stand in one run.
struct RunKey {
  std::uint32_t posture_index = 0;
  bus::Payload description;
  double rate = 0.0;
  std::array<double, 2> shoulder_origin{};
  double shoulder_angle = 0.0;
  bool is_whole_record = false;  // a continuous record is a run by itself
  bool operator==(const RunKey&) const = default;
};

}  // namespace

Result<std::vector<Recording>> recordings_of(store::Store& store, const Session& session,
                                             const Progress& progress) {
  std::vector<RunKey> keys;
  std::vector<Recording> runs;
  std::uint64_t done = 0;
  // The sign that the identification service was told belongs to the channel, not to the service.
  const double force_sign = store::recorded_force_sign(session);
  for (const SessionTrial& trial : session.trials) {
    if (progress) progress(done++, session.trials.size());
    if (!trial.outcome || !trial.record || !trial.record->has_samples) continue;
    TONUS_TRY_ASSIGN(const auto rig, store::rig_in_force(session, trial, force_sign));
    TONUS_TRY_ASSIGN(const auto bytes, bus::encode(rig.description));
    TONUS_TRY_ASSIGN(const auto found, store::read_trial_samples(store, trial));
    const auto& program = trial.outcome->value.program();
    const RunKey key{program.posture_index(),
                     bytes,
                     trial.outcome->value.sample_rate_Hz(),
                     program.shoulder_origin_m(),
                     program.shoulder_angle_rad(),
                     program.kind() == v1::TRIAL_RECORDING};
    auto place = key.is_whole_record ? keys.end() : std::find(keys.begin(), keys.end(), key);
    if (place == keys.end()) {
      runs.push_back(new_run(session, trial, rig, static_cast<int>(runs.size()) + 1));
      place = keys.insert(keys.end(), key);
    }
    Recording& run = runs[static_cast<std::size_t>(place - keys.begin())];
    append_notes(session, trial, found, run);
    append(trial, found, run);
    TONUS_TRY(append_auxiliary(store, trial, rig, run));
  }
  if (progress) progress(session.trials.size(), session.trials.size());
  // A session that ended before its first perturbation has contractions alone, and those make no run.
  std::erase_if(runs, [](const Recording& run) { return run.events.empty(); });
  if (runs.empty()) {
    return fail(ErrorCode::kNotFound, fmt::format("session {}: store '{}' has no trial with samples of it",
                                                  to_hex(session.record.session), store.name()));
  }
  return runs;
}

}  // namespace tonus::formats
