#pragma once

#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "analysis_service/identification/identification_core.hpp"
#include "analysis_service/service/wire.hpp"
#include "services/bus/typed.hpp"
#include "services/core/clock.hpp"
#include "services/runtime/health.hpp"

#include <idl/archive.h>
#include <idl/estimate.h>
#include <idl/rig.h>
#include <idl/session.h>
#include <idl/trial.h>

namespace tonus::identification {

struct ServiceSettings {
  CoreSettings core;
  Id rig{};  ///< Whose trials are identified; those of other rigs are let pass.
  double force_sign =
      1.0;             ///< -1: the force channel of a one-axis rig is the reaction of the limb on the rig.
  std::string served;  ///< The rigs of this process, for its health; empty: this one alone.
};

/// The ends of the service on the bus.
struct ServiceEndpoints {
  bus::TypedReader<v1::RigDescription> descriptions;
  bus::TypedReader<v1::SampleBlock> samples;
  bus::TypedReader<v1::AuxiliaryBlock> auxiliary;
  bus::TypedReader<v1::TrialCommand> commands;
  bus::TypedReader<v1::TrialOutcome> outcomes;
  bus::TypedReader<v1::SessionPlan> plans;
  bus::TypedReader<v1::SessionState> states;
  bus::TypedReader<v1::TrialReview> reviews;
  bus::TypedWriter<v1::TrialVerdict> verdicts;
  bus::TypedWriter<v1::Estimate> live;
  bus::TypedWriter<v1::Estimate> estimates;
  bus::TypedWriter<v1::ArchiveResend> resends;

  [[nodiscard]] static Result<ServiceEndpoints> create(bus::Bus& bus,
                                                       std::shared_ptr<bus::Notifier> notifier);
};

/// Carries messages between the bus and an IdentificationCore, and reports this service's health. A verdict
/// or an estimate that the bus does not take is offered again until it does; of an estimate the newest. One
/// thread calls step().
class IdentificationService {
 public:
  IdentificationService(const ServiceSettings& settings, ServiceEndpoints endpoints,
                        runtime::HealthReporter health, runtime::Roster roster, const Clock& clock);

  /// Handles all there is; returns when to call again at the latest.
  Clock::TimePoint step();

  /// As HealthReporter::check_alone().
  [[nodiscard]] Result<void> check_alone() const { return health_.check_alone(); }

  /// Called once, when the service is to end: publishes what the trials that have come still owe, above all
  /// the estimates behind the last verdicts, and waits until their readers have them. Takes 2 s at most.
  void finish();

 private:
  void take_descriptions();
  void take_plans();
  void take_commands();
  void take_samples(Clock::TimePoint now);
  void take_outcomes(Clock::TimePoint now);
  void take_auxiliary();
  void set_session(const Id& session, const muscles::MuscleSettings& muscles = {});
  void take_states();
  void take_reviews();
  /// Whether the scheduler has gone on from the trial: it was judged before this service began.
  [[nodiscard]] bool is_decided(const TrialPlan& trial) const;
  void publish(const IdentificationCore::Output& output);
  void publish_live();
  void flush();
  [[nodiscard]] std::string why_not_ready();
  void report_health();
  [[nodiscard]] RigUnits units_of(const Id& rig) const;

  ServiceSettings settings_;
  ServiceEndpoints endpoints_;
  runtime::HealthReporter health_;
  runtime::Roster roster_;
  const Clock& clock_;
  IdentificationCore core_;
  std::map<Id, RigUnits> units_;
  Id session_{};
  muscles::MuscleSettings muscles_;  // of its protocol
  std::string session_started_at_;
  std::optional<v1::SessionState> state_;  // of session_, the newest
  std::map<Id, v1::TrialReview> reviews_;  // by trial; they may come before the plan of their session
  std::deque<v1::TrialVerdict> verdicts_;  // not yet taken by the bus
  std::map<Id, v1::Estimate> estimates_;   // likewise, the newest of each
  std::vector<bus::Received<v1::SampleBlock>> blocks_;
  std::vector<Row> rows_;
  bool has_more_samples_ = false;
  double lag_ = 0.0;           // s, of the newest samples when they were handled
  std::uint64_t foreign_ = 0;  // messages of other rigs
};

}  // namespace tonus::identification
