#include "services/formats/hdf5_columns.hpp"

#include "services/core/clock.hpp"
#include "services/formats/csv_columns.hpp"

namespace tonus::formats {
namespace {

using store::Session;

constexpr std::array kSessionAttributes{
    Attribute<Session>{"format", [](const Session&) { return AttributeValue("tonus session"); }},
    Attribute<Session>{"format_version", [](const Session&) { return AttributeValue(std::int64_t{1}); }},
    Attribute<Session>{"session_id",
                       [](const Session& s) { return AttributeValue(to_hex(s.record.session)); }},
    Attribute<Session>{"rig_id", [](const Session& s) { return AttributeValue(to_hex(s.record.rig)); }},
    Attribute<Session>{"subject", [](const Session& s) { return AttributeValue(s.record.subject); }},
    Attribute<Session>{"age_years",
                       [](const Session& s) { return AttributeValue(s.plan.subject_facts().age_years()); }},
    Attribute<Session>{"sex", [](const Session& s) { return AttributeValue(s.plan.subject_facts().sex()); }},
    Attribute<Session>{"handedness",
                       [](const Session& s) { return AttributeValue(s.plan.subject_facts().handedness()); }},
    Attribute<Session>{
        "measured_arm",
        [](const Session& s) { return AttributeValue(s.plan.subject_facts().measured_arm()); }},
    Attribute<Session>{"height_m",
                       [](const Session& s) { return AttributeValue(s.plan.subject_facts().height_m()); }},
    Attribute<Session>{"weight_kg",
                       [](const Session& s) { return AttributeValue(s.plan.subject_facts().weight_kg()); }},
    Attribute<Session>{
        "upper_arm_m",
        [](const Session& s) { return AttributeValue(s.plan.subject_facts().link_lengths_m()[0]); }},
    Attribute<Session>{
        "forearm_m",
        [](const Session& s) { return AttributeValue(s.plan.subject_facts().link_lengths_m()[1]); }},
    Attribute<Session>{
        "upper_arm_circumference_m",
        [](const Session& s) { return AttributeValue(s.plan.subject_facts().circumferences_m()[0]); }},
    Attribute<Session>{
        "forearm_circumference_m",
        [](const Session& s) { return AttributeValue(s.plan.subject_facts().circumferences_m()[1]); }},
    Attribute<Session>{
        "shoulder_x_m",
        [](const Session& s) { return AttributeValue(s.plan.subject_facts().shoulder_m()[0]); }},
    Attribute<Session>{
        "shoulder_y_m",
        [](const Session& s) { return AttributeValue(s.plan.subject_facts().shoulder_m()[1]); }},
    Attribute<Session>{"operator", [](const Session& s) { return AttributeValue(s.plan.operator_name()); }},
    Attribute<Session>{"study", [](const Session& s) { return AttributeValue(s.plan.study()); }},
    Attribute<Session>{"is_pilot",
                       [](const Session& s) { return AttributeValue(std::int64_t{s.plan.is_pilot()}); }},
    Attribute<Session>{"protocol_name",
                       [](const Session& s) { return AttributeValue(s.record.protocol_name); }},
    Attribute<Session>{"protocol_toml",
                       [](const Session& s) { return AttributeValue(s.plan.protocol_toml()); }},
    Attribute<Session>{
        "seed", [](const Session& s) { return AttributeValue(static_cast<std::int64_t>(s.record.seed)); }},
    Attribute<Session>{"started_at", [](const Session& s) { return AttributeValue(s.record.started_at); }},
    Attribute<Session>{"software_version",
                       [](const Session& s) { return AttributeValue(s.record.software_version); }},
};

using Rig = v1::RigDescription;

constexpr std::array kRigAttributes{
    Attribute<Rig>{"name", [](const Rig& d) { return AttributeValue(d.name()); }},
    Attribute<Rig>{"driver", [](const Rig& d) { return AttributeValue(d.driver()); }},
    Attribute<Rig>{"kind", [](const Rig& d) { return AttributeValue(std::int64_t{d.kind()}); }},
    Attribute<Rig>{"displacement_unit", [](const Rig& d) { return AttributeValue(d.displacement_unit()); }},
    Attribute<Rig>{"force_unit", [](const Rig& d) { return AttributeValue(d.force_unit()); }},
    Attribute<Rig>{"force_sensor_angle_rad",
                   [](const Rig& d) { return AttributeValue(d.force_sensor_angle_rad()); }},
    Attribute<Rig>{"force_saturation_V", [](const Rig& d) { return AttributeValue(d.force_saturation_V()); }},
    Attribute<Rig>{"handle_mass_kg", [](const Rig& d) { return AttributeValue(d.handle_mass_kg()); }},
    Attribute<Rig>{"sample_rate_Hz", [](const Rig& d) { return AttributeValue(d.sample_rate_Hz()); }},
    Attribute<Rig>{"calibrated_at", [](const Rig& d) { return AttributeValue(d.calibrated_at()); }},
    Attribute<Rig>{"calibrated_by", [](const Rig& d) { return AttributeValue(d.calibrated_by()); }},
};

constexpr std::array kTrialAttributes{
    Attribute<TrialGroup>{
        "attempt", [](const TrialGroup& t) { return AttributeValue(std::int64_t{t.row.trial.attempt}); }},
    Attribute<TrialGroup>{"posture",
                          [](const TrialGroup& t) { return AttributeValue(t.row.program.posture()); }},
    Attribute<TrialGroup>{
        "set", [](const TrialGroup& t) { return AttributeValue(std::int64_t{t.row.program.set_number()}); }},
    Attribute<TrialGroup>{"posture_x_m",
                          [](const TrialGroup& t) { return AttributeValue(t.row.program.posture_m()[0]); }},
    Attribute<TrialGroup>{"posture_y_m",
                          [](const TrialGroup& t) { return AttributeValue(t.row.program.posture_m()[1]); }},
    Attribute<TrialGroup>{"direction_deg",
                          [](const TrialGroup& t) { return AttributeValue(t.row.program.direction_deg()); }},
    Attribute<TrialGroup>{"amplitude_m",
                          [](const TrialGroup& t) { return AttributeValue(t.row.program.amplitude_m()); }},
    Attribute<TrialGroup>{"rise_time_s",
                          [](const TrialGroup& t) { return AttributeValue(t.row.program.rise_time_s()); }},
    Attribute<TrialGroup>{"hold_s",
                          [](const TrialGroup& t) { return AttributeValue(t.row.program.hold_s()); }},
    Attribute<TrialGroup>{"bias_x_N",
                          [](const TrialGroup& t) { return AttributeValue(t.row.program.bias_N()[0]); }},
    Attribute<TrialGroup>{"bias_y_N",
                          [](const TrialGroup& t) { return AttributeValue(t.row.program.bias_N()[1]); }},
    Attribute<TrialGroup>{"instruction",
                          [](const TrialGroup& t) { return AttributeValue(t.row.program.instruction()); }},
    Attribute<TrialGroup>{
        "end", [](const TrialGroup& t) { return AttributeValue(std::int64_t{t.row.outcome.end()}); }},
    Attribute<TrialGroup>{"detail",
                          [](const TrialGroup& t) { return AttributeValue(t.row.outcome.detail()); }},
    Attribute<TrialGroup>{"sample_rate_Hz",
                          [](const TrialGroup& t) { return AttributeValue(t.row.outcome.sample_rate_Hz()); }},
    Attribute<TrialGroup>{
        "epoch",
        [](const TrialGroup& t) { return AttributeValue(static_cast<std::int64_t>(t.row.outcome.epoch())); }},
    Attribute<TrialGroup>{"first_sequence",
                          [](const TrialGroup& t) {
                            return AttributeValue(static_cast<std::int64_t>(t.row.outcome.first_sequence()));
                          }},
    Attribute<TrialGroup>{"onset_sequence",
                          [](const TrialGroup& t) {
                            return AttributeValue(static_cast<std::int64_t>(t.row.outcome.onset_sequence()));
                          }},
    Attribute<TrialGroup>{"is_valid",
                          [](const TrialGroup& t) { return AttributeValue(std::int64_t{t.reason.empty()}); }},
    Attribute<TrialGroup>{"reason", [](const TrialGroup& t) { return AttributeValue(t.reason); }},
    Attribute<TrialGroup>{
        "missing_samples",
        [](const TrialGroup& t) { return AttributeValue(static_cast<std::int64_t>(t.missing_samples)); }},
};

using Estimate = v1::Estimate;

constexpr std::array kEstimateAttributes{
    Attribute<Estimate>{"posture", [](const Estimate& e) { return AttributeValue(e.posture()); }},
    Attribute<Estimate>{"set",
                        [](const Estimate& e) { return AttributeValue(std::int64_t{e.set_number()}); }},
    Attribute<Estimate>{"instruction", [](const Estimate& e) { return AttributeValue(e.instruction()); }},
    Attribute<Estimate>{"bias_x_N", [](const Estimate& e) { return AttributeValue(e.bias_N()[0]); }},
    Attribute<Estimate>{"bias_y_N", [](const Estimate& e) { return AttributeValue(e.bias_N()[1]); }},
    Attribute<Estimate>{"method", [](const Estimate& e) { return AttributeValue(e.method()); }},
    Attribute<Estimate>{"model", [](const Estimate& e) { return AttributeValue(e.model()); }},
    Attribute<Estimate>{"status", [](const Estimate& e) { return AttributeValue(std::int64_t{e.status()}); }},
    Attribute<Estimate>{"reasons", [](const Estimate& e) { return AttributeValue(reasons_text(e)); }},
    Attribute<Estimate>{"trials_used",
                        [](const Estimate& e) { return AttributeValue(std::int64_t{e.trials_used()}); }},
    Attribute<Estimate>{
        "samples", [](const Estimate& e) { return AttributeValue(static_cast<std::int64_t>(e.samples())); }},
    Attribute<Estimate>{"window_s", [](const Estimate& e) { return AttributeValue(e.window_s()); }},
    Attribute<Estimate>{"condition_number",
                        [](const Estimate& e) { return AttributeValue(e.condition_number()); }},
    Attribute<Estimate>{"degrees_of_freedom",
                        [](const Estimate& e) { return AttributeValue(e.degrees_of_freedom()); }},
    Attribute<Estimate>{"natural_frequency_Hz",
                        [](const Estimate& e) { return AttributeValue(e.natural_frequency_Hz()); }},
    Attribute<Estimate>{"damping_ratio", [](const Estimate& e) { return AttributeValue(e.damping_ratio()); }},
    Attribute<Estimate>{"cutoff_Hz", [](const Estimate& e) { return AttributeValue(e.cutoff_Hz()); }},
    Attribute<Estimate>{"explained_share",
                        [](const Estimate& e) { return AttributeValue(e.explained_share()); }},
    Attribute<Estimate>{"lag_0_s", [](const Estimate& e) { return AttributeValue(e.lag_s()[0]); }},
    Attribute<Estimate>{"lag_1_s", [](const Estimate& e) { return AttributeValue(e.lag_s()[1]); }},
    Attribute<Estimate>{"band_low_Hz", [](const Estimate& e) { return AttributeValue(e.band_low_Hz()); }},
    Attribute<Estimate>{"band_high_Hz", [](const Estimate& e) { return AttributeValue(e.band_high_Hz()); }},
    Attribute<Estimate>{
        "independent_units",
        [](const Estimate& e) { return AttributeValue(std::int64_t{e.independent_units()}); }},
    Attribute<Estimate>{"checks_failed",
                        [](const Estimate& e) {
                          return AttributeValue(static_cast<std::int64_t>(
                              std::count_if(e.checks().begin(), e.checks().end(),
                                            [](const v1::FitCheck& check) { return !check.passed(); })));
                        }},
};

constexpr std::array kNoteAttributes{
    Attribute<NoteRow>{"written_at",
                       [](const NoteRow& n) { return AttributeValue(iso8601(n.note.written_ns())); }},
    Attribute<NoteRow>{"kind", [](const NoteRow& n) { return AttributeValue(n.note.kind()); }},
    Attribute<NoteRow>{
        "attempt",
        [](const NoteRow& n) { return AttributeValue(std::int64_t{store::attempt_of(n.session, n.note)}); }},
    Attribute<NoteRow>{"text", [](const NoteRow& n) { return AttributeValue(n.note.text()); }},
    Attribute<NoteRow>{"written_by", [](const NoteRow& n) { return AttributeValue(n.note.written_by()); }},
    Attribute<NoteRow>{"has_rig_clock",
                       [](const NoteRow& n) { return AttributeValue(std::int64_t{n.note.has_rig_clock()}); }},
    Attribute<NoteRow>{"rig_clock_ns",
                       [](const NoteRow& n) { return AttributeValue(std::int64_t{n.note.rig_clock_ns()}); }},
    Attribute<NoteRow>{
        "epoch", [](const NoteRow& n) { return AttributeValue(static_cast<std::int64_t>(n.note.epoch())); }},
};

using Pair = std::array<double, 2>;

Pair pair(const Eigen::Vector2d& vector) { return {vector[0], vector[1]}; }
std::string counts(const Rig&) { return "count"; }
std::string volts(const Rig&) { return "V"; }
std::string displacement(const Rig& rig) { return rig.displacement_unit(); }
std::string force(const Rig& rig) { return rig.force_unit(); }

constexpr std::array kPairDatasets{
    PairDataset{"encoder", counts, "raw",
                [](const v1::RigSample& raw, const EndpointSample&) -> Pair { return raw.encoder_count(); }},
    PairDataset{"force_raw", volts, "raw, in the sensor's frame",
                [](const v1::RigSample& raw, const EndpointSample&) -> Pair { return raw.force_V(); }},
    PairDataset{"endpoint", displacement, "in the shoulder frame; one-axis rigs: displacement",
                [](const v1::RigSample&, const EndpointSample& converted) { return pair(converted.p_SE); }},
    PairDataset{"force", force, "on the arm, in the shoulder frame",
                [](const v1::RigSample&, const EndpointSample& converted) { return pair(converted.f_S); }},
    PairDataset{"commanded", displacement, "commanded displacement from the posture, shoulder frame",
                [](const v1::RigSample& raw, const EndpointSample&) -> Pair { return raw.commanded_m(); }},
};

}  // namespace

std::span<const Attribute<Session>> session_attributes() { return kSessionAttributes; }
std::span<const Attribute<Rig>> rig_attributes() { return kRigAttributes; }
std::span<const Attribute<TrialGroup>> trial_attributes() { return kTrialAttributes; }
std::span<const Attribute<Estimate>> estimate_attributes() { return kEstimateAttributes; }
std::span<const Attribute<NoteRow>> note_attributes() { return kNoteAttributes; }
std::span<const PairDataset> pair_datasets() { return kPairDatasets; }

}  // namespace tonus::formats
