#include "services/cli/session_text.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/offline/results_json.hpp"
#include "services/cli/results.hpp"
#include "services/contract/message_json.hpp"
#include "services/contract/names.hpp"
#include "services/contract/subject.hpp"
#include "services/contract/subject_json.hpp"
#include "services/core/clock.hpp"
#include "services/runtime/health.hpp"

namespace tonus::cli {
namespace {

using nlohmann::json;
using store::Session;
using store::SessionTrial;

std::string verdict_text(const SessionTrial& trial) {
  if (!trial.outcome) return "no outcome yet";
  const auto verdict = store::standing_verdict(trial);
  if (!verdict) return "no verdict yet";
  if (verdict->is_valid()) return "valid";
  return "rejected: " + (verdict->detail().empty() ? std::string(v1::end_name(trial.outcome->value.end()))
                                                   : verdict->detail());
}

std::string certificate_text(const store::Certificate& c) {
  std::string text = fmt::format("{} of {} samples", c.received, c.expected);
  if (c.resent > 0) text += fmt::format(", {} resent", c.resent);
  if (c.duplicated > 0) text += fmt::format(", {} duplicated", c.duplicated);
  if (c.missing > 0) text += fmt::format(", {} missing", c.missing);
  return text;
}

std::string trial_line(const SessionTrial& trial) {
  std::string text = fmt::format("  {:>4}", trial.attempt);
  const v1::TrialProgram* program = trial.outcome   ? &trial.outcome->value.program()
                                    : trial.command ? &trial.command->value.program()
                                                    : nullptr;
  if (program != nullptr) {
    text += fmt::format("  {:<12} set {}", program->posture(), program->set_number());
    if (program->kind() == v1::TRIAL_PERTURBATION)
      text +=
          fmt::format(", {:>4.0f} deg, {:.1f} mm", program->direction_deg(), 1e3 * program->amplitude_m());
    if (program->bias_N() != std::array<double, 2>{})
      text += fmt::format(", bias ({:.2f}, {:.2f}) N", program->bias_N()[0], program->bias_N()[1]);
  }
  if (trial.record) {
    text += "; " + (trial.record->has_samples ? certificate_text(trial.record->certificate) : "no samples");
    if (!trial.record->is_certified) text += " (not certified)";
  }
  return text + "; " + verdict_text(trial) + "\n";
}

/// What is known of the subject, with commas between; empty: nothing.
std::string facts_text(const v1::SubjectFacts& facts) {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  const auto add_pair = [&](const char* what, const std::array<double, 2>& pair) {
    if (std::isfinite(pair[0]) || std::isfinite(pair[1]))
      add(fmt::format("{} {} and {} m", what, pair[0], pair[1]));
  };
  if (std::isfinite(facts.age_years()))
    add(fmt::format("{}{} years", facts.age_years(), facts.age_years() >= contract::kAgeMost ? "+" : ""));
  if (!facts.sex().empty()) add(facts.sex());
  if (!facts.handedness().empty()) add("handedness " + facts.handedness());
  if (!facts.measured_arm().empty()) add(facts.measured_arm() + " arm measured");
  if (std::isfinite(facts.height_m())) add(fmt::format("{} m", facts.height_m()));
  if (std::isfinite(facts.weight_kg())) add(fmt::format("{} kg", facts.weight_kg()));
  add_pair("links", facts.link_lengths_m());
  add_pair("circumferences", facts.circumferences_m());
  add_pair("shoulder at", facts.shoulder_m());
  return text;
}

/// Who was measured, by whom and for what.
std::string people_text(const v1::SessionPlan& plan) {
  std::string text;
  if (plan.is_pilot()) text += "  PILOT: a rehearsal, no part of a study's results\n";
  if (const std::string facts = facts_text(plan.subject_facts()); !facts.empty())
    text += "  subject: " + facts + "\n";
  if (!plan.operator_name().empty()) text += "  operator: " + plan.operator_name() + "\n";
  if (!plan.study().empty()) text += "  study: " + plan.study() + "\n";
  return text;
}

std::string notes_text(const Session& session) {
  std::string text;
  for (const auto& arrival : session.notes) {
    const v1::SessionNote& note = arrival.value;
    text += fmt::format("  {} {}", iso8601(note.written_ns()), note.kind());
    if (const auto attempt = store::attempt_of(session, note); attempt > 0)
      text += fmt::format(" on trial {}", attempt);
    if (!note.written_by().empty()) text += " by " + note.written_by();
    text += note.has_rig_clock()
                ? fmt::format(", rig's clock {:.3f} s", 1e-9 * static_cast<double>(note.rig_clock_ns()))
                : std::string(", no rig heard");
    text += ": " + note.text() + "\n";
  }
  return text.empty() ? text : "notes\n" + text + "\n";
}

std::string plan_text(const Session& session) {
  const auto& record = session.record;
  std::string text = fmt::format("session {}\n  subject {}, protocol {}, seed {}, started {}, software {}\n",
                                 to_hex(record.session), record.subject, record.protocol_name, record.seed,
                                 record.started_at, record.software_version);
  text += people_text(session.plan);
  if (const auto& state = session.state) {
    text += fmt::format(
        "  {}: {} of {} planned trials counted, {} rejected, {} attempts; {:.1f} s of experiment\n",
        v1::phase_name(state->phase()), state->counted(), state->planned(), state->rejected(),
        state->attempts(), state->experiment_s());
    if (!state->message().empty()) text += "  " + state->message() + "\n";
  }
  for (const auto& posture : session.plan.postures()) {
    text += fmt::format("  posture {:<12} at ({:+.3f}, {:+.3f}) m, {} trials\n", posture.name(),
                        posture.position_m()[0], posture.position_m()[1], posture.trials());
  }
  return text;
}

std::string rig_text(const v1::RigDescription& rig) {
  std::string text = fmt::format("rig {} (driver {}), {} Hz", rig.name(), rig.driver(), rig.sample_rate_Hz());
  if (rig.kind() == v1::RIG_TWO_LINK)
    text += fmt::format(", links {} and {} m", rig.link_lengths_m()[0], rig.link_lengths_m()[1]);
  text += rig.calibrated_at().empty()
              ? ", never calibrated"
              : fmt::format(", calibrated {} by {}", rig.calibrated_at(), rig.calibrated_by());
  return text + "\n";
}

/// Names of services by their ids, from their configurations.
std::string service_name(const Session& session, const Id& id) {
  for (const auto& c : session.configurations) {
    if (c.value.instance_id() == id) return runtime::role_name(c.value.role());
  }
  return to_hex(id).substr(0, 8);
}

std::string surroundings_text(const Session& session) {
  std::string text;
  for (const auto& description : session.descriptions) text += rig_text(description.value);
  for (const auto& c : session.configurations) {
    const auto& value = c.value;
    text += fmt::format("service {} {}, version {}, started {}; {}\n", runtime::role_name(value.role()),
                        value.name(), value.software_version(), iso8601(value.started_ns()), value.build());
  }
  std::map<Id, const v1::ClockOffset*> newest;
  for (const auto& offset : session.clock_offsets) newest[offset.value.pair_id()] = &offset.value;
  for (const auto& [pair, offset] : newest) {
    text +=
        fmt::format("clock of {} minus that of {}: {} ns, uncertain by {} ns\n",
                    service_name(session, offset->answerer_id()), service_name(session, offset->asker_id()),
                    offset->offset_ns(), offset->uncertainty_ns());
  }
  for (const auto& line : session.undecodable) text += "cannot be decoded: " + line + "\n";
  return text;
}

json certificate_json(const store::Certificate& c) {
  return {{"expected", c.expected},
          {"received", c.received},
          {"resent", c.resent},
          {"duplicated", c.duplicated},
          {"missing", c.missing}};
}

json trial_json(const SessionTrial& trial) {
  json object{{"attempt", trial.attempt}, {"trial", to_hex(trial.trial)}};
  if (trial.outcome) {
    const auto& outcome = trial.outcome->value;
    const auto& program = outcome.program();
    object.update({{"planned_index", program.planned_index()},
                   {"posture", program.posture()},
                   {"set", program.set_number()},
                   {"direction_deg", program.direction_deg()},
                   {"amplitude_m", program.amplitude_m()},
                   {"bias_N", program.bias_N()},
                   {"instruction", program.instruction()},
                   {"end", v1::end_name(outcome.end())},
                   {"detail", outcome.detail()},
                   {"epoch", outcome.epoch()},
                   {"first_sequence", outcome.first_sequence()},
                   {"onset_sequence", outcome.onset_sequence()},
                   {"last_sequence", outcome.last_sequence()},
                   {"sample_rate_Hz", outcome.sample_rate_Hz()}});
  }
  if (const auto verdict = store::standing_verdict(trial)) {
    object["is_valid"] = verdict->is_valid();
    object["verdict"] = verdict->detail();
  }
  if (trial.review) object["review"] = contract::message_json(trial.review->value);
  if (trial.record) {
    object["samples"] = certificate_json(trial.record->certificate);
    object["is_certified"] = trial.record->is_certified;
  }
  return object;
}

}  // namespace

std::string session_text(const Session& session) {
  std::string text = plan_text(session);
  text += "\ntrials\n";
  for (const auto& trial : session.trials) text += trial_line(trial);
  text += fmt::format("  sum: {}{}\n\n", certificate_text(session.certificate()),
                      session.is_whole() ? ", whole" : "");
  text += notes_text(session);
  for (const auto& estimate : store::newest_estimates(session)) text += as_text(estimate, {}) + "\n";
  return text + surroundings_text(session);
}

json session_json(const Session& session) {
  const auto& record = session.record;
  json root = identification::json_of(identification::published_results(session));
  root["session"] = {{"id", to_hex(record.session)},
                     {"rig", to_hex(record.rig)},
                     {"subject", record.subject},
                     {"subject_facts", contract::message_json(session.plan.subject_facts())},
                     {"operator_name", session.plan.operator_name()},
                     {"study", session.plan.study()},
                     {"is_pilot", session.plan.is_pilot()},
                     {"protocol_name", record.protocol_name},
                     {"protocol_toml", session.plan.protocol_toml()},
                     {"seed", record.seed},
                     {"planned_trials", record.planned_trials},
                     {"started_at", record.started_at},
                     {"software_version", record.software_version},
                     {"state", session.state ? v1::phase_name(session.state->phase()) : "unknown"},
                     {"is_whole", session.is_whole()},
                     {"samples", certificate_json(session.certificate())}};
  root["trials"] = json::array();
  for (const auto& trial : session.trials) root["trials"].push_back(trial_json(trial));
  root["notes"] = json::array();
  for (const auto& note : session.notes) root["notes"].push_back(contract::message_json(note.value));
  root["configurations"] = json::array();
  for (const auto& c : session.configurations) {
    root["configurations"].push_back({{"service", runtime::role_name(c.value.role())},
                                      {"name", c.value.name()},
                                      {"software_version", c.value.software_version()},
                                      {"build", c.value.build()},
                                      {"started_ns", c.value.started_ns()},
                                      {"configuration_toml", c.value.configuration_toml()}});
  }
  root["clock_offsets"] = json::array();
  for (const auto& o : session.clock_offsets) {
    root["clock_offsets"].push_back({{"of", service_name(session, o.value.answerer_id())},
                                     {"minus", service_name(session, o.value.asker_id())},
                                     {"offset_ns", o.value.offset_ns()},
                                     {"uncertainty_ns", o.value.uncertainty_ns()},
                                     {"measured_ns", o.value.measured_ns()}});
  }
  root["undecodable"] = session.undecodable;
  return root;
}

}  // namespace tonus::cli
