#include "services/verification/reidentification.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <set>
#include <spdlog/fmt/fmt.h>
#include <sstream>

#include "analysis_service/offline/archived_session.hpp"
#include "analysis_service/offline/archived_trial.hpp"
#include "analysis_service/service/command_line.hpp"
#include "analysis_service/service/muscle_settings.hpp"
#include "analysis_service/service/wire.hpp"
#include "services/store/sample_reader.hpp"

namespace tonus::verification {
namespace {

using store::Session;
using store::SessionTrial;

/// After so long without rows the core has given them up, whatever its settings are.
constexpr int kMostSteps = 512;
constexpr std::chrono::seconds kStep{2};

/// The text as it can be parsed again: a setting without value is left out, and a list that is a default is
/// written as one text, "[a,b]", which becomes a list again.
std::string parsable(const std::string& toml) {
  std::istringstream lines(toml);
  std::string text;
  for (std::string line; std::getline(lines, line);) {
    const auto equals = line.find('=');
    if (equals == std::string::npos || line.substr(equals + 1) == "\"\"") continue;
    std::string value = line.substr(equals + 1);
    if (value.starts_with("\"[") && value.ends_with("]\"")) {
      value = value.substr(2, value.size() - 4);
      for (std::size_t comma = value.find(','); comma != std::string::npos;
           comma = value.find(',', comma + 3))
        value.replace(comma, 1, "\",\"");
      value.insert(0, "[\"").append("\"]");
    }
    text += line.substr(0, equals + 1) + value + "\n";
  }
  return text;
}

std::optional<identification::CoreSettings> from_configuration(const std::string& toml) {
  CLI::App app;
  identification::CommandLine command_line;
  command_line.add_to(app);
  app.allow_config_extras(CLI::config_extras_mode::ignore_all);
  std::istringstream text(parsable(toml));
  try {
    app.parse_from_stream(text);
  } catch (const CLI::Error&) {
    return {};
  }
  const auto settings = command_line.settings("");
  if (!settings) return {};
  return settings->core;
}

std::optional<impedance::Options> options_of(const v1::Estimate& estimate) {
  const auto method = impedance::method_named(estimate.method());
  const auto model = impedance::model_named(estimate.model());
  if (!method || !model) return {};
  impedance::Options options;
  options.method = options.record_method = *method;
  options.model = *model;
  if (*method != impedance::Method::kSpectral) options.window = estimate.window_s();
  if (estimate.cutoff_Hz() > 0.0) options.cutoff = estimate.cutoff_Hz();
  if (estimate.damping_ratio() > 0.0) options.damping_ratio = estimate.damping_ratio();
  return options;
}

/// Gives the core the trial's rows as far as they are there.
void add_rows(identification::IdentificationCore& core, const identification::ArchivedTrial& trial) {
  const identification::TrialReport& report = trial.measured.report;
  const std::vector<identification::Row>& rows = trial.measured.rows;
  identification::RowBlock block;
  block.rig = report.plan.rig;
  block.trial = report.plan.trial;
  block.epoch = report.epoch;
  for (std::size_t first = 0; first < rows.size();) {
    std::size_t end = first;
    while (end < rows.size() && trial.is_there[end]) ++end;
    if (end == first) {
      ++first;
      continue;
    }
    block.first_sequence = report.range.first + first;
    block.rows = std::span(rows).subspan(first, end - first);
    core.add(block);
    first = end;
  }
}

identification::RigUnits units_of(const Session& session) {
  if (session.descriptions.empty()) return {};
  const auto& newest = session.descriptions.back().value;
  return {newest.displacement_unit(), newest.force_unit()};
}

/// A core on a clock of its own, and what came out of it.
class Rerun {
 public:
  Rerun(store::Store& store, const Session& session, const CoreChoice& choice)
      : store_(store), session_(session), choice_(choice), core_(choice.core) {
    core_.set_session(session.record.session,
                      identification::muscle_settings_of(session.plan.protocol_toml()));
  }

  Result<void> judge(const SessionTrial& trial) {
    TONUS_TRY_ASSIGN(const auto archived,
                     identification::read_archived_trial(store_, session_, trial, choice_.force_sign));
    const auto& description = archived.rig.description;
    TONUS_TRY_ASSIGN(auto channels, contract::auxiliary_channels_of(description));
    core_.set_rig(description.rig_id(), archived.rig.geometry, description.sample_rate_Hz(),
                  identification::is_rotary({description.displacement_unit(), description.force_unit()}),
                  std::move(channels));
    add_rows(core_, archived);
    TONUS_TRY(add_auxiliary(trial));
    core_.add(archived.measured.report, now_);
    if (trial.verdict) reject_contractions(trial.verdict->received_ns);
    const std::size_t before = found_.verdicts.size();
    for (int step = 0; step < kMostSteps && found_.verdicts.size() == before; ++step) {
      advance();
      now_ += kStep;
    }
    if (found_.verdicts.size() == before)
      found_.remarks.push_back(fmt::format("trial {}: no verdict", trial.attempt));
    // A contraction counts for the trials that were judged before its rejection.
    const bool is_contraction = trial.outcome->value.program().kind() == v1::TRIAL_CONTRACTION;
    if (trial.review && trial.review->value.is_rejected() && !is_contraction)
      core_.reject(trial.trial, trial.attempt);
    return {};
  }

  [[nodiscard]] Reidentification finish() && {
    for (int step = 0; step < 1'000'000 && core_.next_due(now_) <= now_; ++step) advance();
    for (auto& [id, estimate] : estimates_) found_.estimates.push_back(std::move(estimate));
    store::sort_by_condition(found_.estimates);
    return std::move(found_);
  }

 private:
  /// Those that an operator had rejected when a verdict came.
  void reject_contractions(std::uint64_t verdict_ns) {
    for (const SessionTrial& trial : session_.trials) {
      if (!trial.outcome || trial.outcome->value.program().kind() != v1::TRIAL_CONTRACTION) continue;
      if (trial.review && trial.review->value.is_rejected() && trial.review->received_ns < verdict_ns)
        core_.reject(trial.trial, trial.attempt);
    }
  }

  /// As archived: the core puts them together as the service's did.
  Result<void> add_auxiliary(const SessionTrial& trial) {
    if (!trial.record || !trial.record->has_samples) return {};
    const store::BlockQuery query{trial.record->stream, trial.record->range(), true, true};
    return store_.visit_blocks(query, [&](const store::Block& block) -> Result<void> {
      const auto wire = store::decode_auxiliary_block(block);
      if (wire && store::check(block, store_.name())) core_.add(identification::from_wire(*wire));
      return {};
    });
  }

  void advance() {
    const auto output = core_.advance(now_, true);
    for (const auto& judged : output.verdicts)
      found_.verdicts.push_back(identification::to_wire(judged.report, judged.verdict));
    for (const auto& estimate : output.estimates) {
      auto wire = identification::to_wire(estimate, units_of(session_));
      const Id id = wire.estimate_id();
      estimates_.insert_or_assign(id, std::move(wire));
    }
    found_.remarks.insert(found_.remarks.end(), output.remarks.begin(), output.remarks.end());
  }

  store::Store& store_;
  const Session& session_;
  const CoreChoice& choice_;
  identification::IdentificationCore core_;
  Clock::TimePoint now_{};
  Reidentification found_;
  std::map<Id, v1::Estimate> estimates_;
};

}  // namespace

CoreChoice choose_core(const Session& session) {
  for (auto c = session.configurations.rbegin(); c != session.configurations.rend(); ++c) {
    if (c->value.role() != v1::ROLE_IDENTIFICATION || c->value.configuration_toml().empty()) continue;
    const auto core = from_configuration(c->value.configuration_toml());
    if (core) return {*core, store::recorded_force_sign(session), true};
  }
  CoreChoice choice;
  choice.force_sign = store::recorded_force_sign(session);
  std::set<std::pair<std::string, std::string>> seen;
  std::vector<impedance::Options> analyses;
  for (const auto& estimate : session.estimates) {
    const auto options = options_of(estimate.value);
    if (!options || !seen.insert({estimate.value.method(), estimate.value.model()}).second) continue;
    analyses.push_back(*options);
  }
  if (!analyses.empty()) choice.core.book.analyses = analyses;
  return choice;
}

Result<Reidentification> reidentify(store::Store& store, const Session& session, const CoreChoice& choice,
                                    const Progress& progress) {
  Rerun rerun(store, session, choice);
  std::uint64_t done = 0;
  for (const SessionTrial& trial : session.trials) {
    if (progress) progress(done++, session.trials.size());
    if (!trial.outcome) continue;
    TONUS_TRY(rerun.judge(trial));
  }
  if (progress) progress(session.trials.size(), session.trials.size());
  return std::move(rerun).finish();
}

Result<v1::Estimate> reidentify_as_published(store::Store& store, const Session& session,
                                             const v1::Estimate& published, double force_sign,
                                             bool is_frequency_given) {
  auto options = options_of(published);
  if (!options) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("method '{}' with model '{}' is not allowed; expected names that this program knows",
                    published.method(), published.model()));
  }
  if (is_frequency_given && published.natural_frequency_Hz() > 0.0)
    options->natural_frequency = published.natural_frequency_Hz();
  identification::BookSettings settings;
  settings.analyses = {*options};
  identification::ConditionBook book(settings);
  book.set_precision_led(identification::is_precision_led(session));
  for (const v1::TrialRange& used : published.trials()) {
    const auto trial = std::find_if(session.trials.begin(), session.trials.end(),
                                    [&](const SessionTrial& t) { return t.attempt == used.attempt(); });
    if (trial == session.trials.end() || !trial->outcome || !trial->record) {
      return fail(ErrorCode::kDataLoss, fmt::format("trial {} is not in the archive", used.attempt()));
    }
    TONUS_TRY_ASSIGN(const auto archived,
                     identification::read_archived_trial(store, session, *trial, force_sign));
    TONUS_TRY_ASSIGN(const auto converted, identification::convert(archived));
    TONUS_TRY(book.add_valid(archived.measured.report, converted));
  }
  // The condition asked for, and where it is one of several (sets by themselves) no other.
  for (const auto& condition : book.changed()) {
    for (const auto& estimate : book.identify(condition)) {
      auto wire = identification::to_wire(estimate, units_of(session));
      if (wire.estimate_id() == published.estimate_id()) return wire;
    }
  }
  return fail(ErrorCode::kInvalidArgument, "its condition cannot be made from the trials that it names");
}

}  // namespace tonus::verification
