#include "services/exchange/session_recordings.hpp"

#include <algorithm>
#include <optional>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/identification/wire.hpp"
#include "services/bus/typed.hpp"
#include "services/exchange/reidentification.hpp"
#include "services/exchange/trial_data.hpp"
#include "services/recording/file_name.hpp"

namespace tonus::exchange {
namespace {

using archive::Session;
using archive::SessionTrial;
using recording::Recording;

std::string label_or(std::string_view name, const char* fallback) {
  std::string label = recording::to_label(name);
  return label.empty() ? fallback : label;
}

std::string participant_of(std::string_view subject) {
  if (subject.starts_with("sub-")) subject.remove_prefix(4);
  return "sub-" + label_or(subject, "unknown");
}

/// A run without rows, for trials like this one.
Result<Recording> new_run(const Session& session, const SessionTrial& trial,
                          const v1::RigDescription& description, int run) {
  auto rig = identification::from_wire(description);
  if (!rig) return rig.error();
  // The sign that the identification service was told belongs to the channel, not to the service.
  if (rig->kind == RigKind::kOneAxis) rig->force_calibration *= choose_core(session).force_sign;
  const auto& outcome = trial.outcome->value;
  const auto& program = outcome.program();
  Recording record;
  record.participant.id = participant_of(session.record.subject);
  record.session = "ses-" + to_hex(session.record.session).substr(0, 8);
  record.task = label_or(session.record.protocol_name, "posture");
  record.posture = program.posture();
  record.acquisition = recording::to_label(program.posture());
  record.posture_position = Eigen::Vector2d(program.posture_m()[0], program.posture_m()[1]);
  record.run = run;
  record.sampling_frequency = outcome.sample_rate_Hz();
  record.rig = *rig;
  record.is_raw = rig->kind == RigKind::kTwoLink;
  record.shoulder = shoulder_of(trial);
  record.displacement_unit = description.displacement_unit();
  record.force_unit = description.force_unit();
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
  event.set = program.set_number();
  if (program.kind() == v1::TRIAL_PERTURBATION) {
    event.direction_deg = program.direction_deg();
    event.amplitude_m = program.amplitude_m();
    event.rise_time_s = program.rise_time_s();
  } else {
    event.duration_s = longest;
  }
  event.bias_N = program.bias_N();
  event.reason = why_not_counted(trial);
  event.is_valid = event.reason.empty();
  event.instruction = program.instruction();
  event.bias_hold_s = program.bias_hold_s();
  event.bias_threshold_N = program.bias_threshold_N();
  event.trial_onset_s = static_cast<double>(rows_before) / rate;
  event.trial_duration_s = static_cast<double>(rows) / rate;
  return event;
}

void append(const SessionTrial& trial, const TrialSamples& found, Recording& record) {
  record.events.push_back(event_of(trial, record.rows.size(), record.sampling_frequency));
  for (const v1::RigSample& sample : found.samples) {
    recording::Row row;
    row.is_missing = (sample.flags() & kNotMeasured) != 0;
    row.raw.acquisition_ns = recording::row_time_ns(record, record.rows.size());
    if (!row.is_missing) {
      row.raw.encoder_count = sample.encoder_count();
      row.raw.force_V = sample.force_V();
    }
    record.rows.push_back(row);
    record.commanded.push_back(row.is_missing ? std::array<double, 2>{} : sample.commanded_m());
    record.phases.push_back(std::min<std::uint8_t>(sample.phase(), v1::PHASE_SAFE));
  }
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

std::string why_not_counted(const SessionTrial& trial) {
  if (!trial.verdict) return "no verdict";
  if (trial.verdict->value.is_valid()) return {};
  return trial.verdict->value.detail().empty() ? "judged invalid" : trial.verdict->value.detail();
}

Result<std::vector<Recording>> recordings_of(archive::Store& store, const Session& session,
                                             const Progress& progress) {
  std::vector<RunKey> keys;
  std::vector<Recording> runs;
  std::uint64_t done = 0;
  for (const SessionTrial& trial : session.trials) {
    if (progress) progress(done++, session.trials.size());
    if (!trial.outcome || !trial.record || !trial.record->has_samples) continue;
    const auto description = description_of(session, trial);
    if (!description) return description.error();
    const auto bytes = bus::encode(*description);
    if (!bytes) return bytes.error();
    const auto found = read_all_samples(store, trial);
    if (!found) return found.error();
    const auto& program = trial.outcome->value.program();
    const RunKey key{program.posture_index(),
                     *bytes,
                     trial.outcome->value.sample_rate_Hz(),
                     program.shoulder_origin_m(),
                     program.shoulder_angle_rad(),
                     program.kind() == v1::TRIAL_RECORDING};
    auto place = key.is_whole_record ? keys.end() : std::find(keys.begin(), keys.end(), key);
    if (place == keys.end()) {
      auto run = new_run(session, trial, *description, static_cast<int>(runs.size()) + 1);
      if (!run) return run.error();
      runs.push_back(std::move(*run));
      place = keys.insert(keys.end(), key);
    }
    append(trial, *found, runs[static_cast<std::size_t>(place - keys.begin())]);
  }
  if (progress) progress(session.trials.size(), session.trials.size());
  if (runs.empty()) {
    return fail(ErrorCode::kNotFound, fmt::format("session {}: has no trial with samples in store '{}'",
                                                  to_hex(session.record.session), store.name()));
  }
  return runs;
}

}  // namespace tonus::exchange
