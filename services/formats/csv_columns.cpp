#include "services/formats/csv_columns.hpp"

#include <array>
#include <spdlog/fmt/fmt.h>

#include "services/contract/rig.hpp"
#include "services/core/clock.hpp"
#include "services/store/archived_trial.hpp"

namespace tonus::formats {
namespace {

std::string_view validity_of(const store::SessionTrial& trial) {
  const auto verdict = store::standing_verdict(trial);
  if (!verdict) return "";
  return verdict->is_valid() ? "true" : "false";
}

/// A cell that is empty where nothing was measured.
template <auto kWrite>
void measured(const SampleRow& row, CsvLine& line) {
  if (row.is_measured) {
    kWrite(row, line);
  } else {
    line.nothing();
  }
}

template <double EstimateRow::Spread::*kMember>
void spread(const EstimateRow& row, CsvLine& line) {
  if (row.spread) {
    line.number((*row.spread).*kMember);
  } else {
    line.nothing();
  }
}

using store::Session;

constexpr std::array kSessionColumns{
    CsvColumn<Session>{"session_id", "", "32 hexadecimal digits",
                       [](const Session& s, CsvLine& line) { line.text(to_hex(s.record.session)); }},
    CsvColumn<Session>{"subject", "", "the subject's name",
                       [](const Session& s, CsvLine& line) { line.text(s.record.subject); }},
    CsvColumn<Session>{"started_at", "", "ISO 8601, UTC",
                       [](const Session& s, CsvLine& line) { line.text(s.record.started_at); }},
    CsvColumn<Session>{"protocol", "", "its name",
                       [](const Session& s, CsvLine& line) { line.text(s.record.protocol_name); }},
    CsvColumn<Session>{"seed", "", "of orders and waits",
                       [](const Session& s, CsvLine& line) { line.whole(s.record.seed); }},
    CsvColumn<Session>{"operator", "", "who ran the session",
                       [](const Session& s, CsvLine& line) { line.text(s.plan.operator_name()); }},
    CsvColumn<Session>{"study", "", "that the session belongs to; empty: none",
                       [](const Session& s, CsvLine& line) { line.text(s.plan.study()); }},
    CsvColumn<Session>{
        "pilot", "", "true: a rehearsal, no part of a study's results",
        [](const Session& s, CsvLine& line) { line.text(s.plan.is_pilot() ? "true" : "false"); }},
    CsvColumn<Session>{
        "age", "year", "of the subject; 89 stands for 89 and more",
        [](const Session& s, CsvLine& line) { line.number(s.plan.subject_facts().age_years()); }},
    CsvColumn<Session>{"sex", "", "male, female, other; empty: not known",
                       [](const Session& s, CsvLine& line) { line.text(s.plan.subject_facts().sex()); }},
    CsvColumn<Session>{
        "handedness", "", "right, left, ambidextrous",
        [](const Session& s, CsvLine& line) { line.text(s.plan.subject_facts().handedness()); }},
    CsvColumn<Session>{
        "measured_arm", "", "right, left",
        [](const Session& s, CsvLine& line) { line.text(s.plan.subject_facts().measured_arm()); }},
    CsvColumn<Session>{
        "height_m", "m", "of the subject",
        [](const Session& s, CsvLine& line) { line.number(s.plan.subject_facts().height_m()); }},
    CsvColumn<Session>{
        "weight_kg", "kg", "of the subject",
        [](const Session& s, CsvLine& line) { line.number(s.plan.subject_facts().weight_kg()); }},
    CsvColumn<Session>{
        "upper_arm_m", "m", "length of the upper arm",
        [](const Session& s, CsvLine& line) { line.number(s.plan.subject_facts().link_lengths_m()[0]); }},
    CsvColumn<Session>{
        "forearm_m", "m", "length of the forearm with the hand, to the handle's centre",
        [](const Session& s, CsvLine& line) { line.number(s.plan.subject_facts().link_lengths_m()[1]); }},
    CsvColumn<Session>{
        "upper_arm_circumference_m", "m", "of the upper arm where it is widest",
        [](const Session& s, CsvLine& line) { line.number(s.plan.subject_facts().circumferences_m()[0]); }},
    CsvColumn<Session>{
        "forearm_circumference_m", "m", "of the forearm where it is widest",
        [](const Session& s, CsvLine& line) { line.number(s.plan.subject_facts().circumferences_m()[1]); }},
    CsvColumn<Session>{
        "shoulder_x_m", "m", "centre of the shoulder joint in the robot's frame, x",
        [](const Session& s, CsvLine& line) { line.number(s.plan.subject_facts().shoulder_m()[0]); }},
    CsvColumn<Session>{
        "shoulder_y_m", "m", "centre of the shoulder joint in the robot's frame, y",
        [](const Session& s, CsvLine& line) { line.number(s.plan.subject_facts().shoulder_m()[1]); }},
    CsvColumn<Session>{"software_version", "", "of the scheduler",
                       [](const Session& s, CsvLine& line) { line.text(s.record.software_version); }},
};

constexpr std::array kNoteColumns{
    CsvColumn<NoteRow>{"written_at", "", "ISO 8601, UTC",
                       [](const NoteRow& row, CsvLine& line) { line.text(iso8601(row.note.written_ns())); }},
    CsvColumn<NoteRow>{"kind", "", "note, marker",
                       [](const NoteRow& row, CsvLine& line) { line.text(row.note.kind()); }},
    CsvColumn<NoteRow>{"attempt", "", "trial that it is about; empty: none",
                       [](const NoteRow& row, CsvLine& line) {
                         const auto attempt = store::attempt_of(row.session, row.note);
                         attempt > 0 ? line.whole(attempt) : line.nothing();
                       }},
    CsvColumn<NoteRow>{"text", "", "what was written",
                       [](const NoteRow& row, CsvLine& line) { line.text(row.note.text()); }},
    CsvColumn<NoteRow>{"written_by", "", "who wrote it",
                       [](const NoteRow& row, CsvLine& line) { line.text(row.note.written_by()); }},
    CsvColumn<NoteRow>{"epoch", "ns", "start of the rig's agent, UTC; empty: the rig was not heard",
                       [](const NoteRow& row, CsvLine& line) {
                         row.note.has_rig_clock() ? line.whole(row.note.epoch()) : line.nothing();
                       }},
    CsvColumn<NoteRow>{"rig_clock_ns", "ns", "rig's monotonic clock, as acquisition_ns of the samples",
                       [](const NoteRow& row, CsvLine& line) {
                         row.note.has_rig_clock() ? line.whole(row.note.rig_clock_ns()) : line.nothing();
                       }},
};

constexpr std::array kTrialColumns{
    CsvColumn<TrialRow>{"attempt", "", "number of the trial, unique in the session",
                        [](const TrialRow& row, CsvLine& line) { line.whole(row.program.attempt()); }},
    CsvColumn<TrialRow>{"planned_index", "", "place in the plan, from 0; repeats of a rejected trial keep it",
                        [](const TrialRow& row, CsvLine& line) { line.whole(row.program.planned_index()); }},
    CsvColumn<TrialRow>{"posture", "", "name of the posture",
                        [](const TrialRow& row, CsvLine& line) { line.text(row.program.posture()); }},
    CsvColumn<TrialRow>{"set", "", "number of the set",
                        [](const TrialRow& row, CsvLine& line) { line.whole(row.program.set_number()); }},
    CsvColumn<TrialRow>{"x_m", "m", "hand's place, x in the shoulder frame",
                        [](const TrialRow& row, CsvLine& line) { line.number(row.program.posture_m()[0]); }},
    CsvColumn<TrialRow>{"y_m", "m", "hand's place, y in the shoulder frame",
                        [](const TrialRow& row, CsvLine& line) { line.number(row.program.posture_m()[1]); }},
    CsvColumn<TrialRow>{"direction_deg", "deg",
                        "of the perturbation, counter-clockwise from the shoulder frame's x axis",
                        [](const TrialRow& row, CsvLine& line) { line.number(row.program.direction_deg()); }},
    CsvColumn<TrialRow>{"amplitude_m", "m", "of the commanded displacement",
                        [](const TrialRow& row, CsvLine& line) { line.number(row.program.amplitude_m()); }},
    CsvColumn<TrialRow>{"rise_time_s", "s", "of the commanded displacement",
                        [](const TrialRow& row, CsvLine& line) { line.number(row.program.rise_time_s()); }},
    CsvColumn<TrialRow>{"hold_s", "s", "from onset to the end of the perturbation",
                        [](const TrialRow& row, CsvLine& line) { line.number(row.program.hold_s()); }},
    CsvColumn<TrialRow>{"wait_s", "s", "at rest before the onset",
                        [](const TrialRow& row, CsvLine& line) { line.number(row.program.wait_s()); }},
    CsvColumn<TrialRow>{"bias_x_N", "N", "bias force on the arm, x in the shoulder frame",
                        [](const TrialRow& row, CsvLine& line) { line.number(row.program.bias_N()[0]); }},
    CsvColumn<TrialRow>{"bias_y_N", "N", "bias force on the arm, y in the shoulder frame",
                        [](const TrialRow& row, CsvLine& line) { line.number(row.program.bias_N()[1]); }},
    CsvColumn<TrialRow>{"instruction", "", "what the subject was told; empty: hold still",
                        [](const TrialRow& row, CsvLine& line) { line.text(row.program.instruction()); }},
    CsvColumn<TrialRow>{"end", "",
                        "how the rig ended it: 0 completed, 1 aborted, 2 faulted, 3 not centred, 4 bias not "
                        "reached, 5 refused, 6 broken off",
                        [](const TrialRow& row, CsvLine& line) {
                          line.whole(static_cast<std::uint32_t>(row.outcome.end()));
                        }},
    CsvColumn<TrialRow>{"valid", "", "true, false; empty: no verdict",
                        [](const TrialRow& row, CsvLine& line) { line.text(validity_of(row.trial)); }},
    CsvColumn<TrialRow>{"reason", "", "why it does not count; of a trial rejected by hand: by whom, and why",
                        [](const TrialRow& row, CsvLine& line) {
                          line.text(row.trial.verdict ? store::why_not_counted(row.trial) : std::string());
                        }},
    CsvColumn<TrialRow>{"epoch", "ns", "start of the rig's agent, UTC; names the stream of samples",
                        [](const TrialRow& row, CsvLine& line) { line.whole(row.outcome.epoch()); }},
    CsvColumn<TrialRow>{"first_sequence", "", "number of the first sample",
                        [](const TrialRow& row, CsvLine& line) { line.whole(row.outcome.first_sequence()); }},
    CsvColumn<TrialRow>{"onset_sequence", "", "number of the first sample of the perturbation",
                        [](const TrialRow& row, CsvLine& line) { line.whole(row.outcome.onset_sequence()); }},
    CsvColumn<TrialRow>{"last_sequence", "", "number of the last sample",
                        [](const TrialRow& row, CsvLine& line) { line.whole(row.outcome.last_sequence()); }},
    CsvColumn<TrialRow>{
        "sample_rate_Hz", "Hz", "samples a second",
        [](const TrialRow& row, CsvLine& line) { line.number(row.outcome.sample_rate_Hz()); }},
    CsvColumn<TrialRow>{"expected_samples", "", "of the certificate",
                        [](const TrialRow& row, CsvLine& line) { line.whole(row.certificate.expected); }},
    CsvColumn<TrialRow>{"received_samples", "", "of the certificate",
                        [](const TrialRow& row, CsvLine& line) { line.whole(row.certificate.received); }},
    CsvColumn<TrialRow>{"resent_samples", "", "of the certificate",
                        [](const TrialRow& row, CsvLine& line) { line.whole(row.certificate.resent); }},
    CsvColumn<TrialRow>{"duplicated_samples", "", "of the certificate",
                        [](const TrialRow& row, CsvLine& line) { line.whole(row.certificate.duplicated); }},
    CsvColumn<TrialRow>{"missing_samples", "", "of the certificate",
                        [](const TrialRow& row, CsvLine& line) { line.whole(row.certificate.missing); }},
    CsvColumn<TrialRow>{"co_contraction", "", "index of antagonists before the onset, 0 to 1",
                        [](const TrialRow& row, CsvLine& line) {
                          if (!row.trial.verdict) return line.nothing();
                          line.number(row.trial.verdict->value.co_contraction());
                        }},
};

constexpr std::array kMuscleColumns{
    CsvColumn<MuscleRow>{"attempt", "", "number of the trial, unique in the session",
                         [](const MuscleRow& row, CsvLine& line) { line.whole(row.attempt); }},
    CsvColumn<MuscleRow>{"channel", "", "EMG channel",
                         [](const MuscleRow& row, CsvLine& line) { line.text(row.activity.channel()); }},
    CsvColumn<MuscleRow>{
        "is_normalised", "",
        "true: relative to the reference contraction, 1 = as much; false: in the channel's unit",
        [](const MuscleRow& row, CsvLine& line) {
          line.text(row.activity.is_normalised() ? "true" : "false");
        }},
    CsvColumn<MuscleRow>{
        "before_onset", "", "mean rectified EMG of the rest before the onset",
        [](const MuscleRow& row, CsvLine& line) { line.number(row.activity.before_onset()); }},
    CsvColumn<MuscleRow>{
        "short_latency", "", "the same, 20 to 50 ms after the onset",
        [](const MuscleRow& row, CsvLine& line) { line.number(row.activity.short_latency()); }},
    CsvColumn<MuscleRow>{
        "long_latency", "", "the same, 50 to 100 ms after the onset",
        [](const MuscleRow& row, CsvLine& line) { line.number(row.activity.long_latency()); }},
};

constexpr std::array kAuxiliaryColumns{
    CsvColumn<AuxiliaryRow>{"channel", "", "name of the channel",
                            [](const AuxiliaryRow& row, CsvLine& line) { line.text(row.channel); }},
    CsvColumn<AuxiliaryRow>{"time_s", "s", "from the onset of the perturbation",
                            [](const AuxiliaryRow& row, CsvLine& line) { line.number(row.time); }},
    CsvColumn<AuxiliaryRow>{"value", "", "in the unit beside it; empty: not measured",
                            [](const AuxiliaryRow& row, CsvLine& line) { line.number(row.value); }},
    CsvColumn<AuxiliaryRow>{"unit", "", "of the value",
                            [](const AuxiliaryRow& row, CsvLine& line) { line.text(row.unit); }},
};

constexpr std::array kSampleColumns{
    CsvColumn<SampleRow>{"sequence", "", "number of the sample in its stream",
                         [](const SampleRow& row, CsvLine& line) { line.whole(row.sequence); }},
    CsvColumn<SampleRow>{"time_s", "s", "from the onset of the perturbation, by the sample's number and rate",
                         [](const SampleRow& row, CsvLine& line) { line.number(row.time); }},
    CsvColumn<SampleRow>{
        "acquisition_ns", "ns", "rig's monotonic clock",
        measured<[](const SampleRow& row, CsvLine& line) { line.whole(row.sample.acquisition_ns()); }>},
    CsvColumn<SampleRow>{
        "phase", "",
        "0 idle, 1 centring, 2 waiting, 3 bias ramp, 4 bias hold, 5 perturbing, 6 returning, 7 safe",
        measured<[](const SampleRow& row, CsvLine& line) {
          line.whole(static_cast<unsigned>(row.sample.phase()));
        }>},
    CsvColumn<SampleRow>{
        "q1_count", "count", "encoder of the inner joint, raw (or converted displacement)",
        measured<[](const SampleRow& row, CsvLine& line) { line.number(row.sample.encoder_count()[0]); }>},
    CsvColumn<SampleRow>{
        "q2_count", "count", "encoder of the outer joint, raw",
        measured<[](const SampleRow& row, CsvLine& line) { line.number(row.sample.encoder_count()[1]); }>},
    CsvColumn<SampleRow>{
        "f1_V", "V", "force sensor, first axis, raw (or converted force)",
        measured<[](const SampleRow& row, CsvLine& line) { line.number(row.sample.force_V()[0]); }>},
    CsvColumn<SampleRow>{
        "f2_V", "V", "force sensor, second axis, raw",
        measured<[](const SampleRow& row, CsvLine& line) { line.number(row.sample.force_V()[1]); }>},
    CsvColumn<SampleRow>{
        "x_m", "m", "endpoint in the shoulder frame, or the displacement of a one-axis rig in its unit",
        measured<[](const SampleRow& row, CsvLine& line) { line.number(row.converted.p_SE[0]); }>},
    CsvColumn<SampleRow>{
        "y_m", "m", "endpoint in the shoulder frame",
        measured<[](const SampleRow& row, CsvLine& line) { line.number(row.converted.p_SE[1]); }>},
    CsvColumn<SampleRow>{
        "fx_N", "N", "force on the arm in the shoulder frame, or the force of a one-axis rig in its unit",
        measured<[](const SampleRow& row, CsvLine& line) { line.number(row.converted.f_S[0]); }>},
    CsvColumn<SampleRow>{
        "fy_N", "N", "force on the arm in the shoulder frame",
        measured<[](const SampleRow& row, CsvLine& line) { line.number(row.converted.f_S[1]); }>},
    CsvColumn<SampleRow>{
        "xc_m", "m", "commanded displacement in the shoulder frame, from the posture",
        measured<[](const SampleRow& row, CsvLine& line) { line.number(row.sample.commanded_m()[0]); }>},
    CsvColumn<SampleRow>{
        "yc_m", "m", "commanded displacement in the shoulder frame",
        measured<[](const SampleRow& row, CsvLine& line) { line.number(row.sample.commanded_m()[1]); }>},
    CsvColumn<SampleRow>{"saturated", "", "1: the force sensor was at its end stop",
                         measured<[](const SampleRow& row, CsvLine& line) {
                           line.whole(contract::flags_of(row.sample).is_saturated ? 1 : 0);
                         }>},
};

constexpr std::array kEstimateColumns{
    CsvColumn<EstimateRow>{"posture", "", "name of the posture",
                           [](const EstimateRow& row, CsvLine& line) { line.text(row.estimate.posture()); }},
    CsvColumn<EstimateRow>{
        "set", "", "number of the set; 0: all",
        [](const EstimateRow& row, CsvLine& line) { line.whole(row.estimate.set_number()); }},
    CsvColumn<EstimateRow>{
        "bias_x_N", "N", "bias force on the arm, x",
        [](const EstimateRow& row, CsvLine& line) { line.number(row.estimate.bias_N()[0]); }},
    CsvColumn<EstimateRow>{
        "bias_y_N", "N", "bias force on the arm, y",
        [](const EstimateRow& row, CsvLine& line) { line.number(row.estimate.bias_N()[1]); }},
    CsvColumn<EstimateRow>{
        "instruction", "", "what the subject was told",
        [](const EstimateRow& row, CsvLine& line) { line.text(row.estimate.instruction()); }},
    CsvColumn<EstimateRow>{"method", "", "of identification",
                           [](const EstimateRow& row, CsvLine& line) { line.text(row.estimate.method()); }},
    CsvColumn<EstimateRow>{"model", "", "of the force",
                           [](const EstimateRow& row, CsvLine& line) { line.text(row.estimate.model()); }},
    CsvColumn<EstimateRow>{"status", "", "0 ok, 1 undetermined, 2 suspect",
                           [](const EstimateRow& row, CsvLine& line) {
                             line.whole(static_cast<std::uint32_t>(row.estimate.status()));
                           }},
    CsvColumn<EstimateRow>{
        "reasons", "", "why it is not ok, separated by semicolons",
        [](const EstimateRow& row, CsvLine& line) { line.text(reasons_text(row.estimate)); }},
    CsvColumn<EstimateRow>{
        "trials_used", "", "trials behind the estimate",
        [](const EstimateRow& row, CsvLine& line) { line.whole(row.estimate.trials_used()); }},
    CsvColumn<EstimateRow>{"quantity", "",
                           "M mass, B damping, K stiffness, X0 spring centre, sigma fitting error, "
                           "explained_share, lag (of the force), band, independent_units; M_size, M_shape, "
                           "M_orientation, M_curl of the ellipse; M_known_bias of the method; M_covariance: "
                           "row and column count the elements xx, xy, yx, yy; B and K likewise",
                           [](const EstimateRow& row, CsvLine& line) { line.text(row.quantity); }},
    CsvColumn<EstimateRow>{"row", "", "of the element, from 1",
                           [](const EstimateRow& row, CsvLine& line) { line.whole(row.row + 1); }},
    CsvColumn<EstimateRow>{"column", "", "of the element, from 1",
                           [](const EstimateRow& row, CsvLine& line) { line.whole(row.column + 1); }},
    CsvColumn<EstimateRow>{"value", "see unit", "the estimate",
                           [](const EstimateRow& row, CsvLine& line) { line.number(row.value); }},
    CsvColumn<EstimateRow>{"standard_error", "see unit", "of the value",
                           spread<&EstimateRow::Spread::standard_error>},
    CsvColumn<EstimateRow>{"low95", "see unit", "lower end of its 95 % interval",
                           spread<&EstimateRow::Spread::low95>},
    CsvColumn<EstimateRow>{"high95", "see unit", "upper end of its 95 % interval",
                           spread<&EstimateRow::Spread::high95>},
    CsvColumn<EstimateRow>{"unit", "", "of value, standard_error, low95 and high95",
                           [](const EstimateRow& row, CsvLine& line) { line.text(row.unit); }},
};

}  // namespace

std::span<const CsvColumn<MuscleRow>> muscle_columns() { return kMuscleColumns; }
std::span<const CsvColumn<AuxiliaryRow>> auxiliary_columns() { return kAuxiliaryColumns; }
std::span<const CsvColumn<Session>> session_columns() { return kSessionColumns; }
std::span<const CsvColumn<NoteRow>> note_columns() { return kNoteColumns; }
std::string reasons_text(const v1::Estimate& estimate) {
  return fmt::format("{}", fmt::join(estimate.reasons(), "; "));
}

std::span<const CsvColumn<TrialRow>> trial_columns() { return kTrialColumns; }
std::span<const CsvColumn<SampleRow>> sample_columns() { return kSampleColumns; }
std::span<const CsvColumn<EstimateRow>> estimate_columns() { return kEstimateColumns; }

}  // namespace tonus::formats
