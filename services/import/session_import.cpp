#include "services/import/session_import.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <spdlog/fmt/fmt.h>

#include "idl/bounds.hpp"
#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/contract/rig.hpp"
#include "services/contract/subject.hpp"
#include "services/contract/trial.hpp"
#include "services/core/clock.hpp"
#include "services/core/crc32c.hpp"
#include "services/store/block_header.hpp"
#include "services/store/memory_store.hpp"
#include "services/store/session_reader.hpp"
#include "services/store/wire.hpp"
#include "services/verification/reidentification.hpp"

namespace tonus::session_import {
namespace {

using recording::PerturbationEvent;
using recording::Recording;
using store::Batch;

constexpr std::size_t kSamplesABlock = 128;
constexpr std::size_t kMostValues = 14000;  // of AuxiliaryBlock

v1::RigDescription description_of(const Recording& record) {
  v1::RigDescription wire;
  wire.name(record.tracking_system);
  wire.driver("import");
  contract::put_geometry(record.rig, wire);
  wire.loop_rate_Hz(record.sampling_frequency);
  wire.sample_rate_Hz(record.sampling_frequency);
  wire.displacement_unit(record.displacement_unit);
  wire.force_unit(record.force_unit);
  std::vector<AuxiliaryChannel> channels;
  for (const AuxiliarySeries& series : record.auxiliary) channels.push_back(series.channel);
  contract::put_auxiliary_channels(channels, wire);
  return wire;
}

v1::TrialKind kind_of(const PerturbationEvent& event) {
  return event.is_continuous() ? v1::TRIAL_RECORDING : v1::TRIAL_PERTURBATION;
}

/// Rows of the record that become a trial's samples.
recording::Stretch range_of(const Recording& record, const PerturbationEvent& event, v1::TrialKind kind) {
  if (!event.trial_onset_s || !event.trial_duration_s) return recording::stretch_of(record, event);
  const std::size_t last = record.rows.size() - 1;
  const auto row_at = [&](double time) {
    const auto row = std::llround(std::max(time, 0.0) * record.sampling_frequency);
    return std::min(static_cast<std::size_t>(row), last);
  };
  const std::size_t first = row_at(*event.trial_onset_s);
  const std::size_t end = row_at(*event.trial_onset_s) +
                          static_cast<std::size_t>(std::max<long long>(
                              1, std::llround(*event.trial_duration_s * record.sampling_frequency)));
  const std::size_t onset = kind == v1::TRIAL_RECORDING ? first : row_at(event.onset_s);
  return {first, std::clamp(onset, first, std::min(end - 1, last)), std::min(end - 1, last)};
}

Eigen::Vector2d place_of(const Recording& record) {
  if (record.posture_position) return *record.posture_position;
  if (record.rig.kind == RigKind::kOneAxis || record.events.empty()) return Eigen::Vector2d::Zero();
  const auto stretch = range_of(record, record.events.front(), kind_of(record.events.front()));
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double count = 0.0;
  for (std::size_t i = stretch.first; i <= stretch.onset; ++i) {
    if (record.rows[i].is_missing) continue;
    sum += convert(record.rig, record.shoulder, record.rows[i].raw).p_SE;
    count += 1.0;
  }
  return count > 0.0 ? Eigen::Vector2d(sum / count) : sum;
}

/// A word of BIDS, which takes its first letter too, in any case; empty where it is none of `words`.
std::string word_of(const std::string& text, std::initializer_list<std::string_view> words) {
  std::string lower = text;
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const std::string_view word : words) {
    if (lower == word || lower == word.substr(0, 1)) return std::string(word);
  }
  return {};
}

/// What the dataset knows of a participant.
v1::SubjectFacts facts_of(const recording::Participant& participant) {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const auto pair = [](const std::optional<double>& a, const std::optional<double>& b) {
    return std::array{a.value_or(kUnknown), b.value_or(kUnknown)};
  };
  v1::SubjectFacts facts = contract::unknown_subject();
  if (participant.age)
    facts.age_years(participant.is_age_or_more ? contract::kAgeMost
                                               : std::min(*participant.age, contract::kAgeMost));
  facts.sex(word_of(participant.sex, {"male", "female", "other"}));
  facts.handedness(word_of(participant.handedness, {"right", "left", "ambidextrous"}));
  facts.measured_arm(word_of(participant.measured_arm, {"right", "left"}));
  facts.height_m(participant.height_m.value_or(kUnknown));
  facts.weight_kg(participant.weight_kg.value_or(kUnknown));
  facts.link_lengths_m(pair(participant.upper_arm_m, participant.forearm_m));
  facts.circumferences_m(pair(participant.upper_arm_circumference_m, participant.forearm_circumference_m));
  facts.shoulder_m(pair(participant.shoulder_x_m, participant.shoulder_y_m));
  return facts;
}

/// Makes one session's messages and samples.
class SessionMaker {
 public:
  SessionMaker(const Id& session, const v1::RigDescription& description, const Recording& first,
               std::uint64_t epoch, const ImportSettings& settings)
      : settings_(settings), description_(description) {
    plan_.session_id(session);
    plan_.rig_id(description.rig_id());
    plan_.subject(first.participant.id);
    plan_.subject_facts(facts_of(first.participant));
    plan_.operator_name(first.session_facts.operator_name);
    plan_.study(first.session_facts.study);
    plan_.is_pilot(first.session_facts.is_pilot);
    plan_.protocol_name(first.task);
    plan_.started_at(iso8601(settings.imported_ns));
    plan_.software_version(settings.software_version);
    stream_ = {description.rig_id(), epoch};
    for (const v1::AuxiliaryChannel& channel : description.auxiliary_channels())
      auxiliary_values_ += channel.values_per_sample();
  }

  Result<void> add(const Recording& record) {
    v1::PlannedPosture posture;
    posture.name(record.posture.empty() ? fmt::format("run-{:02}", record.run) : record.posture);
    const Eigen::Vector2d place = place_of(record);
    posture.position_m({place[0], place[1]});
    posture.trials(static_cast<std::uint32_t>(record.events.size()));
    const auto posture_index = static_cast<std::uint32_t>(plan_.postures().size());
    plan_.postures().push_back(posture);
    const contract::TrialPlace at{posture.name(), posture_index, place};
    auto contraction = record.contractions.begin();
    for (const PerturbationEvent& event : record.events) {
      for (; contraction != record.contractions.end() && contraction->onset_s < event.onset_s; ++contraction)
        TONUS_TRY(add_trial(record, *contraction, v1::TRIAL_CONTRACTION, at));
      TONUS_TRY(add_trial(record, event, kind_of(event), at));
    }
    for (; contraction != record.contractions.end(); ++contraction)
      TONUS_TRY(add_trial(record, *contraction, v1::TRIAL_CONTRACTION, at));
    return {};
  }

  /// With what identification makes of it.
  Result<ImportedSession> finish(const Progress& progress) && {
    plan_.planned_trials(counted_);
    plan_.protocol_toml("schema = 1\nkind = \"recording\"\n");
    std::vector<store::Message> trials = std::exchange(batch_.messages, {});
    TONUS_TRY(put_beginning());
    std::move(trials.begin(), trials.end(), std::back_inserter(batch_.messages));
    batch_.sessions = {store::to_record(plan_)};
    store::Coverage coverage;
    coverage.add({0, next_});
    batch_.streams = {{stream_, 0, coverage, 0, 0, auxiliary_values_, {}}};
    if (auxiliary_values_ > 0) batch_.streams.front().auxiliary_coverage = coverage;
    TONUS_TRY(identify(progress));
    TONUS_TRY(put_end());
    return ImportedSession{store::to_record(plan_), std::move(batch_)};
  }

 private:
  /// The trial's own number; the next free one where another run of the session has it, or no attempt can.
  std::uint32_t attempt_of(const PerturbationEvent& event) {
    const bool is_possible = event.trial >= 1 && event.trial <= INT32_MAX;
    if (is_possible && attempts_.insert(static_cast<std::uint32_t>(event.trial)).second)
      return static_cast<std::uint32_t>(event.trial);
    return *attempts_.insert(attempts_.empty() ? 1 : *attempts_.rbegin() + 1).first;
  }

  template <typename T>
  Result<void> put(const topics::Topic<T>& topic, const Id& key, const T& value) {
    auto payload = bus::encode(value);
    if (!payload)
      return fail(payload.error().code, std::string(topic.spec.name) + ": " + payload.error().message);
    store::Message message{std::string(topic.spec.name),
                           key,
                           plan_.session_id(),
                           settings_.imported_ns,
                           0,
                           std::make_shared<const std::vector<std::byte>>(std::move(*payload))};
    message.checksum = crc32c(*message.payload);
    batch_.messages.push_back(std::move(message));
    return {};
  }

  Result<void> put_beginning() {
    TONUS_TRY(put(topics::kRigDescription, description_.rig_id(), description_));
    TONUS_TRY(put(topics::kSessionPlan, plan_.session_id(), plan_));
    v1::ServiceConfiguration configuration;
    configuration.instance_id(id_of("service/identification/import"));
    configuration.role(v1::ROLE_IDENTIFICATION);
    configuration.name("import");
    configuration.software_version(settings_.software_version);
    configuration.configuration_toml(settings_.configuration_toml);
    configuration.started_ns(settings_.imported_ns);
    return put(topics::kServiceConfiguration, configuration.instance_id(), configuration);
  }

  Result<void> add_trial(const Recording& record, const PerturbationEvent& event, v1::TrialKind kind,
                         const contract::TrialPlace& at) {
    const recording::Stretch range = range_of(record, event, kind);
    v1::TrialOutcome outcome;
    v1::TrialProgram& program = outcome.program();
    program = contract::new_program(kind, at);
    program.session_id(plan_.session_id());
    program.rig_id(plan_.rig_id());
    program.attempt(attempt_of(event));
    program.planned_index(counted_++);
    contract::put_shoulder(record.shoulder, program);
    program.set_number(kind == v1::TRIAL_CONTRACTION ? 0 : static_cast<std::int32_t>(event.set));
    program.instruction(event.instruction);
    program.direction_deg(event.direction_deg.value_or(0.0));
    program.amplitude_m(event.amplitude_m.value_or(0.0));
    program.rise_time_s(event.rise_time_s.value_or(0.0));
    program.hold_s(event.duration_s);
    program.bias_N(event.bias_N);
    program.bias_hold_s(event.bias_hold_s.value_or(0.0));
    program.bias_threshold_N(event.bias_threshold_N.value_or(0.0));
    outcome.trial_id(trial_id(plan_.session_id(), program.attempt()));
    outcome.epoch(stream_.epoch);
    outcome.end(event.is_valid ? v1::TRIAL_COMPLETED : v1::TRIAL_BROKEN_OFF);
    outcome.detail(event.is_valid ? std::string() : "flagged invalid in the dataset: " + event.reason);
    outcome.first_sequence(next_);
    outcome.onset_sequence(next_ + (range.onset - range.first));
    outcome.last_sequence(next_ + (range.last - range.first));
    outcome.sample_rate_Hz(record.sampling_frequency);
    TONUS_TRY(add_samples(record, range, outcome.trial_id()));
    TONUS_TRY_ASSIGN(auto trial, store::to_record(outcome));
    trial.certificate = {trial.range().count(), trial.range().count(), 0, 0, 0};
    trial.is_certified = true;
    trial.certified_ns = settings_.imported_ns;
    batch_.trials.push_back(trial);
    return put(topics::kTrialOutcome, outcome.trial_id(), outcome);
  }

  Result<void> add_samples(const Recording& record, const recording::Stretch& range, const Id& trial) {
    std::size_t most = kSamplesABlock;
    if (auxiliary_values_ > 0) most = std::min<std::size_t>(most, kMostValues / auxiliary_values_);
    for (std::size_t first = range.first; first <= range.last; first += most) {
      const std::size_t end = std::min(first + most, range.last + 1);
      v1::SampleBlock wire;
      wire.rig_id(stream_.rig);
      wire.session_id(plan_.session_id());
      wire.trial_id(trial);
      wire.epoch(stream_.epoch);
      wire.first_sequence(next_);
      for (std::size_t i = first; i < end; ++i) wire.samples().push_back(sample_of(record, i, range));
      TONUS_TRY_ASSIGN(auto payload, bus::encode(wire));
      TONUS_TRY_ASSIGN(auto block, store::read_block_header(payload));
      add_block(std::move(block), std::move(payload));
      TONUS_TRY(add_auxiliary(record, first, end, wire));
      next_ += end - first;
    }
    // As on a rig, time continues: the next trial's stamps follow.
    elapsed_ns_ += recording::row_time_ns(record, range.last + 1 - range.first);
    return {};
  }

  void add_block(store::Block block, bus::Payload payload) {
    block.received_ns = settings_.imported_ns;
    block.payload = std::make_shared<const bus::Payload>(std::move(payload));
    block.checksum = crc32c(*block.payload);
    batch_.blocks.push_back(std::move(block));
  }

  /// What the auxiliary channels gave with rows first .. end - 1, which are the samples of `samples`.
  Result<void> add_auxiliary(const Recording& record, std::size_t first, std::size_t end,
                             const v1::SampleBlock& samples) {
    if (auxiliary_values_ == 0) return {};
    v1::AuxiliaryBlock wire;
    wire.rig_id(samples.rig_id());
    wire.session_id(samples.session_id());
    wire.trial_id(samples.trial_id());
    wire.epoch(samples.epoch());
    wire.first_sequence(samples.first_sequence());
    wire.sample_count(static_cast<std::uint32_t>(end - first));
    wire.values().reserve((end - first) * auxiliary_values_);
    for (std::size_t row = first; row < end; ++row) {
      for (const AuxiliarySeries& series : record.auxiliary) {
        const auto from = series.values.begin() + static_cast<std::ptrdiff_t>(row * series.values_per_sample);
        wire.values().insert(wire.values().end(), from, from + series.values_per_sample);
      }
    }
    TONUS_TRY_ASSIGN(auto payload, bus::encode(wire));
    TONUS_TRY_ASSIGN(auto header, store::read_auxiliary_header(payload));
    add_block(std::move(header.block), std::move(payload));
    return {};
  }

  [[nodiscard]] v1::RigSample sample_of(const Recording& record, std::size_t row,
                                        const recording::Stretch& range) const {
    const auto& given = record.rows[row];
    v1::RigSample sample;
    sample.acquisition_ns(elapsed_ns_ + recording::row_time_ns(record, row - range.first));
    sample.encoder_count(given.raw.encoder_count);
    sample.force_V(given.raw.force_V);
    sample.commanded_m(record.commanded.empty() ? recording::kNoCommand : record.commanded[row]);
    const auto assumed =
        static_cast<std::uint8_t>(row < range.onset ? v1::PHASE_WAITING : v1::PHASE_PERTURBING);
    sample.phase(record.phases.empty() ? assumed : record.phases[row]);
    contract::SampleFlags flags;
    flags.is_missing = given.is_missing;
    flags.is_saturated = !given.is_missing &&
                         std::any_of(given.raw.force_V.begin(), given.raw.force_V.end(), [&](double volts) {
                           return std::abs(volts) >= record.rig.force_saturation_V;
                         });
    contract::put_flags(flags, sample);
    return sample;
  }

  /// The core's verdicts and estimates, as the service would have published them.
  Result<void> identify(const Progress& progress) {
    store::MemoryStore store;
    TONUS_TRY(store.commit(batch_));
    TONUS_TRY_ASSIGN(const auto session, store::read_session(store, plan_.session_id()));
    TONUS_TRY_ASSIGN(const auto found,
                     verification::reidentify(store, session, {settings_.core, 1.0, true}, progress));
    for (const auto& verdict : found.verdicts) {
      valid_ += verdict.is_valid() ? 1U : 0U;
      TONUS_TRY(put(topics::kTrialVerdict, verdict.trial_id(), verdict));
    }
    for (const auto& estimate : found.estimates) {
      TONUS_TRY(put(topics::kEstimateCondition, estimate.estimate_id(), estimate));
    }
    return {};
  }

  Result<void> put_end() {
    v1::SessionState state;
    state.session_id(plan_.session_id());
    state.phase(v1::SESSION_COMPLETED);
    state.message("imported from " + settings_.dataset);
    state.attempts(counted_);
    state.counted(valid_);
    state.rejected(counted_ - valid_);
    state.planned(counted_);
    store::SessionCertificate certificate;
    certificate.session = plan_.session_id();
    certificate.rig = plan_.rig_id();
    certificate.end = v1::SESSION_COMPLETED;
    for (const store::TrialRecord& trial : batch_.trials) certificate.add(trial);
    certificate.certified_ns = settings_.imported_ns;
    batch_.certificates = {certificate};
    return put(topics::kSessionState, plan_.session_id(), state);
  }

  const ImportSettings& settings_;
  v1::RigDescription description_;
  v1::SessionPlan plan_;
  store::StreamKey stream_;
  std::uint32_t auxiliary_values_ = 0;  ///< With each sample, of all channels.
  Batch batch_;
  std::uint64_t next_ = 0;
  std::int64_t elapsed_ns_ = 0;
  std::set<std::uint32_t> attempts_;
  std::uint32_t counted_ = 0;
  std::uint32_t valid_ = 0;
};

/// The samples' checksum: what tells one session of a participant from another of the same labels.
std::uint32_t checksum_of(const std::vector<const Recording*>& records) {
  std::vector<std::byte> bytes;
  for (const Recording* record : records) {
    for (const auto& row : record->rows) {
      const auto append = [&bytes](const auto& values) {
        const auto* from = reinterpret_cast<const std::byte*>(values.data());
        bytes.insert(bytes.end(), from, from + sizeof(values));
      };
      append(row.raw.encoder_count);
      append(row.raw.force_V);
    }
  }
  return crc32c(bytes);
}

}  // namespace

Result<std::vector<ImportedSession>> sessions_of(const std::vector<Recording>& recordings,
                                                 const ImportSettings& settings, const Progress& progress) {
  struct Group {
    v1::RigDescription description;
    std::vector<const Recording*> records;
  };
  std::map<std::tuple<std::string, std::string, std::string, bus::Payload>, Group> groups;
  for (const Recording& record : recordings) {
    if (auto good = contract::check_subject_facts(facts_of(record.participant)); !good)
      return fail(good.error().code, record.participant.id + ": " + good.error().message);
    if (auto good = validate(record.rig); !good) {
      return fail(good.error().code, recording::describe(record) + ": " + good.error().message);
    }
    const auto description = description_of(record);
    const auto bytes = bus::encode(description);
    if (!bytes) return fail(bytes.error().code, recording::describe(record) + ": " + bytes.error().message);
    auto& group = groups[{record.participant.id, record.session, record.task, *bytes}];
    group.description = description;
    group.records.push_back(&record);
  }
  std::vector<ImportedSession> sessions;
  for (auto& [key, group] : groups) {
    const auto& [participant, session, task, bytes] = key;
    const std::uint32_t rig_checksum = crc32c(bytes);
    group.description.rig_id(id_of(fmt::format("imported rig {:08x}", rig_checksum)));
    const Id id = id_of(fmt::format("imported {}/{}/{}/{:08x}/{:08x}", participant, session, task,
                                    rig_checksum, checksum_of(group.records)));
    // Two sessions of one rig are two starts of it.
    std::uint64_t epoch = 0;
    for (std::size_t i = 0; i < 7; ++i) epoch = epoch << 8U | id[i];
    SessionMaker maker(id, group.description, *group.records.front(), epoch, settings);
    for (const Recording* record : group.records) {
      TONUS_TRY(maker.add(*record));
    }
    TONUS_TRY_ASSIGN(auto made, std::move(maker).finish(progress));
    sessions.push_back(std::move(made));
  }
  return sessions;
}

Result<std::vector<store::SessionRecord>> store_sessions(store::Store& store,
                                                         const std::vector<ImportedSession>& sessions,
                                                         const std::function<bool()>& is_interrupted) {
  TONUS_TRY_ASSIGN(const auto known, store.sessions());
  for (const ImportedSession& session : sessions) {
    const bool is_there = std::any_of(known.begin(), known.end(), [&](const store::SessionRecord& s) {
      return s.session == session.record.session;
    });
    if (is_there) {
      return fail(
          ErrorCode::kAlreadyExists,
          fmt::format("session {} ({}, {}): already exists in store '{}'", to_hex(session.record.session),
                      session.record.subject, session.record.protocol_name, store.name()));
    }
  }
  std::vector<store::SessionRecord> imported;
  for (const ImportedSession& session : sessions) {
    TONUS_TRY(store.commit(session.batch));
    imported.push_back(session.record);
    if (is_interrupted && is_interrupted() && imported.size() < sessions.size()) {
      return fail(ErrorCode::kUnavailable, fmt::format("interrupted: {} of {} sessions are in store '{}'",
                                                       imported.size(), sessions.size(), store.name()));
    }
  }
  return imported;
}

}  // namespace tonus::session_import
