#include "tests/support/made_up_session/made_up_session.hpp"

#include <gtest/gtest.h>

#include "analysis_service/identification/identification_core.hpp"
#include "analysis_service/service/wire.hpp"
#include "idl/bounds.hpp"
#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/contract/subject.hpp"
#include "services/core/crc32c.hpp"
#include "services/store/block_header.hpp"
#include "services/store/wire.hpp"
#include "tests/support/made_up_trial/made_up_trial.hpp"

namespace tonus::made_up {
namespace {

using identification::MeasuredTrial;

constexpr std::size_t kRowsABlock = 50;

v1::TrialOutcome outcome_of(const MeasuredTrial& trial, bool is_broken_off) {
  const auto& plan = trial.report.plan;
  v1::TrialOutcome outcome;
  outcome.trial_id(plan.trial);
  outcome.epoch(trial.report.epoch);
  outcome.end(is_broken_off ? v1::TRIAL_BROKEN_OFF : v1::TRIAL_COMPLETED);
  outcome.detail(is_broken_off ? "made up" : "");
  outcome.first_sequence(trial.report.range.first);
  outcome.onset_sequence(trial.report.onset);
  outcome.last_sequence(trial.report.range.last());
  outcome.sample_rate_Hz(trial.report.sample_rate);
  auto& program = outcome.program();
  program.session_id(plan.session);
  program.rig_id(plan.rig);
  program.attempt(plan.attempt);
  program.planned_index(plan.planned_index);
  program.posture(plan.posture);
  program.posture_index(plan.posture_index);
  program.posture_m({plan.position[0], plan.position[1]});
  program.shoulder_origin_m({plan.shoulder.origin[0], plan.shoulder.origin[1]});
  program.shoulder_angle_rad(plan.shoulder.angle);
  program.set_number(plan.set);
  program.direction_deg(45.0 * (plan.attempt - 1));
  program.amplitude_m(0.005);
  program.rise_time_s(0.2);
  program.hold_s(1.75);
  program.wait_s(1.0);
  program.bias_N({plan.bias[0], plan.bias[1]});
  program.bias_hold_s(plan.bias_hold);
  program.bias_threshold_N(plan.bias_threshold);
  return outcome;
}

class Writer {
 public:
  Writer(store::Store& store, const SessionRecipe& recipe) : store_(store), recipe_(recipe) {}

  template <typename T>
  void put(const topics::Topic<T>& topic, const Id& key, const T& value) {
    store::Message message{std::string(topic.spec.name), key, identification::testing::made_up_session(),
                           recipe_.received_ns,          0,   nullptr};
    message.payload = std::make_shared<const bus::Payload>(*bus::encode(value));
    message.checksum = crc32c(*message.payload);
    batch_.messages.push_back(std::move(message));
  }

  void put_samples(const MeasuredTrial& trial) {
    const auto& plan = trial.report.plan;
    for (std::size_t first = 0; first < trial.rows.size(); first += kRowsABlock) {
      v1::SampleBlock wire;
      wire.rig_id(plan.rig);
      wire.session_id(plan.session);
      wire.trial_id(plan.trial);
      wire.epoch(trial.report.epoch);
      wire.first_sequence(trial.report.range.first + first);
      for (std::size_t i = first; i < std::min(first + kRowsABlock, trial.rows.size()); ++i) {
        const auto& row = trial.rows[i];
        v1::RigSample sample;
        sample.acquisition_ns(row.raw.acquisition_ns);
        sample.encoder_count(row.raw.encoder_count);
        sample.force_V(row.raw.force_V);
        sample.commanded_m(row.commanded);
        sample.phase(static_cast<std::uint8_t>(row.phase));
        wire.samples().push_back(sample);
      }
      if (recipe_.is_block_lost && recipe_.is_block_lost(wire.first_sequence())) continue;
      const auto payload = *bus::encode(wire);
      store::Block block = *store::read_block_header(payload);
      block.received_ns = recipe_.received_ns;
      block.payload = std::make_shared<const bus::Payload>(payload);
      block.checksum = crc32c(payload);
      coverage_[block.stream].add(block.range());
      batch_.blocks.push_back(std::move(block));
    }
  }

  void put_outcome(const v1::TrialOutcome& outcome) {
    put(topics::kTrialOutcome, outcome.trial_id(), outcome);
    auto record = *store::to_record(outcome);
    auto& counts = record.certificate;
    counts.expected = record.range().count();
    counts.received = coverage_[record.stream].count_in(record.range());
    counts.missing = counts.expected - counts.received;
    record.is_certified = counts.missing == 0;
    record.certified_ns = record.is_certified ? recipe_.received_ns : 0;
    batch_.trials.push_back(record);
  }

  void put_review(std::uint32_t attempt) {
    v1::TrialReview review;
    review.trial_id(trial_id(identification::testing::made_up_session(), attempt));
    review.session_id(identification::testing::made_up_session());
    review.attempt(attempt);
    review.is_rejected(true);
    review.reason("coughed");
    review.reviewed_by("Ada");
    put(topics::kTrialReview, review.trial_id(), review);
  }

  void put_notes() {
    std::uint64_t number = 0;
    for (v1::SessionNote note : recipe_.notes) {
      note.note_id(id_of("note " + std::to_string(++number)));
      note.session_id(identification::testing::made_up_session());
      note.written_ns(recipe_.received_ns + number);
      put(topics::kSessionNote, note.note_id(), note);
    }
  }

  /// What a service makes of the trials, with the rows as they were measured.
  void put_results() {
    identification::IdentificationCore core{identification::CoreSettings{}};
    core.set_session(identification::testing::made_up_session());
    const auto description = made_up_description();
    core.set_rig(description.rig_id(), *contract::geometry_of(description), description.sample_rate_Hz());
    Clock::TimePoint now{};
    std::map<Id, v1::Estimate> estimates;
    const auto take = [&](const identification::IdentificationCore::Output& output) {
      for (const auto& judged : output.verdicts) {
        auto verdict = identification::to_wire(judged.report, judged.verdict);
        if (recipe_.spoil_verdict) recipe_.spoil_verdict(verdict);
        put(topics::kTrialVerdict, verdict.trial_id(), verdict);
      }
      for (const auto& estimate : output.estimates) {
        auto wire = identification::to_wire(estimate, {});
        estimates.insert_or_assign(wire.estimate_id(), wire);
      }
    };
    for (const auto& trial : recipe_.trials) {
      for (const auto& block : identification::testing::blocks_of(trial, 37)) core.add(block);
      const bool is_broken_off = trial.report.plan.attempt == recipe_.rejected_attempt;
      core.add(identification::from_wire(outcome_of(trial, is_broken_off)), now);
      for (int step = 0; step < 3; ++step) take(core.advance(now += std::chrono::seconds(1), true));
    }
    while (core.next_due(now) <= now) take(core.advance(now, true));
    if (recipe_.reviewed_attempt > 0) {
      put_review(recipe_.reviewed_attempt);
      core.reject(trial_id(identification::testing::made_up_session(), recipe_.reviewed_attempt),
                  recipe_.reviewed_attempt);
      while (core.next_due(now) <= now) take(core.advance(now, true));
    }
    for (auto& [id, estimate] : estimates) {
      if (recipe_.spoil_estimate) recipe_.spoil_estimate(estimate);
      put(topics::kEstimateCondition, id, estimate);
    }
  }

  void finish(const store::SessionRecord& record) {
    batch_.sessions = {record};
    for (const auto& [key, coverage] : coverage_)
      batch_.streams.push_back({key, coverage.ranges().front().first, coverage, 0, 0});
    if (recipe_.spoil_batch) recipe_.spoil_batch(batch_);
    const auto committed = store_.commit(batch_);
    ASSERT_TRUE(committed) << committed.error().message;
  }

 private:
  store::Store& store_;
  const SessionRecipe& recipe_;
  store::Batch batch_;
  std::map<store::StreamKey, store::Coverage> coverage_;
};

}  // namespace

v1::RigDescription made_up_description() {
  const RigGeometry rig = identification::testing::made_up_rig();
  v1::RigDescription description;
  description.rig_id(identification::testing::made_up_rig_id());
  description.name("rig");
  description.driver("made up");
  description.kind(v1::RIG_TWO_LINK);
  description.link_lengths_m({rig.links.l1, rig.links.l2});
  description.encoder_counts_per_unit(rig.counts_per_unit);
  description.encoder_zero_count(rig.encoder_zero);
  description.encoder_sign(rig.encoder_sign);
  const auto& c = rig.force_calibration;
  description.force_calibration_N_per_V({c(0, 0), c(0, 1), c(1, 0), c(1, 1)});
  description.force_offset_V({rig.force_offset_V[0], rig.force_offset_V[1]});
  description.force_sensor_angle_rad(rig.force_sensor_angle);
  description.force_saturation_V(rig.force_saturation_V);
  description.handle_mass_kg(rig.handle_mass);
  description.loop_rate_Hz(1000.0);
  description.sample_rate_Hz(identification::testing::kRate);
  description.displacement_unit("m");
  description.force_unit("N");
  return description;
}

SessionRecipe unloaded_session() {
  SessionRecipe recipe;
  recipe.trials = identification::testing::made_up_condition();
  // A rig numbers its samples without gaps.
  std::uint64_t next = 1000;
  for (auto& trial : recipe.trials) {
    auto& report = trial.report;
    report.onset = next + (report.onset - report.range.first);
    report.range = {next, next + trial.rows.size()};
    next += trial.rows.size();
  }
  return recipe;
}

store::SessionRecord put_session(store::Store& store, SessionRecipe recipe) {
  Writer writer(store, recipe);
  const auto description = made_up_description();
  const Id session = identification::testing::made_up_session();
  v1::SessionPlan plan;
  plan.session_id(session);
  plan.rig_id(description.rig_id());
  plan.subject("sub-07");
  plan.protocol_name("unloaded");
  plan.protocol_toml("schema = 1\n");
  plan.seed(3);
  plan.planned_trials(static_cast<std::uint32_t>(recipe.trials.size()));
  plan.started_at("2026-01-02T03:04:05Z");
  plan.software_version("0.1.0");
  plan.subject_facts(contract::unknown_subject());
  if (recipe.set_plan) recipe.set_plan(plan);
  writer.put(topics::kSessionPlan, session, plan);
  writer.put(topics::kRigDescription, description.rig_id(), description);
  for (const auto& trial : recipe.trials) {
    const auto outcome = outcome_of(trial, trial.report.plan.attempt == recipe.rejected_attempt);
    v1::TrialCommand command;
    command.trial_id(outcome.trial_id());
    command.program(outcome.program());
    writer.put(topics::kTrialCommand, command.trial_id(), command);
    writer.put_samples(trial);
    writer.put_outcome(outcome);
  }
  writer.put_results();
  writer.put_notes();
  v1::SessionState state;
  state.session_id(session);
  state.phase(recipe.is_over ? v1::SESSION_COMPLETED : v1::SESSION_RUNNING);
  writer.put(topics::kSessionState, session, state);
  const auto record = store::to_record(plan);
  writer.finish(record);
  return record;
}

}  // namespace tonus::made_up
