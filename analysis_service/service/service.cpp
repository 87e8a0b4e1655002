#include "analysis_service/service/service.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <utility>

#include "analysis_service/service/muscle_settings.hpp"
#include "idl/bounds.hpp"
#include "idl/topics.hpp"
#include "services/protocol/protocol.hpp"
#include "services/runtime/drain.hpp"

namespace tonus::identification {
namespace {

/// What a session asks of identification, by its protocol.
struct Needs {
  std::vector<impedance::Method> methods;  // by which conditions end, or bias forces are directed
  bool is_precision_led = false;
};

Needs needs_of(const v1::SessionPlan& plan) {
  Needs needs;
  const auto protocol = protocol::parse_protocol(plan.protocol_toml(), "protocol");
  if (!protocol) return needs;  // a plan of other programs
  needs.is_precision_led = protocol->stop_when.has_value();
  for (const std::string& name : protocol::methods_needed(*protocol)) {
    if (const auto method = impedance::method_named(name)) needs.methods.push_back(*method);
  }
  return needs;
}

constexpr std::size_t kBlocksAtOnce = 512;
constexpr std::chrono::milliseconds kRetry{20};
/// Of trials rejected by hand; beyond that those of other sessions are let go.
constexpr std::size_t kMostReviews = 16384;
/// Verdicts that the bus did not take; more means that the bus is gone.
constexpr std::size_t kMostVerdictsHeld = 4096;

}  // namespace

Result<ServiceEndpoints> ServiceEndpoints::create(bus::Bus& bus, std::shared_ptr<bus::Notifier> notifier) {
  auto descriptions = bus::TypedReader<v1::RigDescription>::create(bus, topics::kRigDescription, notifier);
  if (!descriptions) return descriptions.error();
  auto samples = bus::TypedReader<v1::SampleBlock>::create(bus, topics::kRigSamples, notifier);
  if (!samples) return samples.error();
  auto auxiliary = bus::TypedReader<v1::AuxiliaryBlock>::create(bus, topics::kRigAuxiliary, notifier);
  if (!auxiliary) return auxiliary.error();
  auto commands = bus::TypedReader<v1::TrialCommand>::create(bus, topics::kTrialCommand, notifier);
  if (!commands) return commands.error();
  auto outcomes = bus::TypedReader<v1::TrialOutcome>::create(bus, topics::kTrialOutcome, notifier);
  if (!outcomes) return outcomes.error();
  auto plans = bus::TypedReader<v1::SessionPlan>::create(bus, topics::kSessionPlan, notifier);
  if (!plans) return plans.error();
  auto states = bus::TypedReader<v1::SessionState>::create(bus, topics::kSessionState, notifier);
  if (!states) return states.error();
  TONUS_TRY_ASSIGN(auto reviews,
                   bus::TypedReader<v1::TrialReview>::create(bus, topics::kTrialReview, notifier));
  auto verdicts = bus::TypedWriter<v1::TrialVerdict>::create(bus, topics::kTrialVerdict);
  if (!verdicts) return verdicts.error();
  auto live = bus::TypedWriter<v1::Estimate>::create(bus, topics::kEstimateLive);
  if (!live) return live.error();
  auto estimates = bus::TypedWriter<v1::Estimate>::create(bus, topics::kEstimateCondition);
  if (!estimates) return estimates.error();
  auto resends = bus::TypedWriter<v1::ArchiveResend>::create(bus, topics::kArchiveResend);
  if (!resends) return resends.error();
  return ServiceEndpoints{std::move(*descriptions), std::move(*samples),   std::move(*auxiliary),
                          std::move(*commands),     std::move(*outcomes),  std::move(*plans),
                          std::move(*states),       std::move(reviews),    std::move(*verdicts),
                          std::move(*live),         std::move(*estimates), std::move(*resends)};
}

IdentificationService::IdentificationService(const ServiceSettings& settings, ServiceEndpoints endpoints,
                                             runtime::HealthReporter health, runtime::Roster roster,
                                             const Clock& clock)
    : settings_(settings),
      endpoints_(std::move(endpoints)),
      health_(std::move(health)),
      roster_(std::move(roster)),
      clock_(clock),
      core_(settings.core) {}

Clock::TimePoint IdentificationService::step() {
  const Clock::TimePoint now = clock_.now();
  take_descriptions();
  take_plans();
  take_commands();
  take_samples(now);
  take_auxiliary();
  publish_live();
  take_outcomes(now);
  take_states();
  take_reviews();
  publish(core_.advance(now, endpoints_.resends.status().matched_readers > 0));
  flush();
  report_health();
  const Clock::TimePoint report_due = health_.publish_if_due();
  if (has_more_samples_) return now;
  const bool has_unsent = !verdicts_.empty() || !estimates_.empty();
  return std::min({core_.next_due(now), report_due, has_unsent ? now + kRetry : Clock::TimePoint::max()});
}

void IdentificationService::finish() {
  constexpr std::chrono::milliseconds kToPublish{1000};
  constexpr std::chrono::milliseconds kToArrive{500};
  const Clock::TimePoint limit = clock_.now() + kToPublish;
  bool is_owing = true;
  while (is_owing && clock_.now() < limit) {
    const bool is_due = step() <= clock_.now();
    is_owing = is_due || !verdicts_.empty() || !estimates_.empty();
  }
  const bool are_verdicts_there = endpoints_.verdicts.wait_acknowledged(kToArrive);
  const bool are_estimates_there = endpoints_.estimates.wait_acknowledged(kToArrive);
  if (is_owing || !are_verdicts_there || !are_estimates_there)
    spdlog::warn("ends with {} verdicts and {} estimates that not every reader has", verdicts_.size(),
                 estimates_.size());
}

void IdentificationService::take_descriptions() {
  for (const auto& received : runtime::drain(endpoints_.descriptions)) {
    const v1::RigDescription& description = received.value;
    if (description.rig_id() != settings_.rig) {
      ++foreign_;
      continue;
    }
    auto geometry = contract::geometry_of(description);
    if (!geometry) {
      spdlog::error("the description of rig {} is refused: {}", description.name(), geometry.error().message);
      continue;
    }
    if (geometry->kind == RigKind::kOneAxis) geometry->force_calibration *= settings_.force_sign;
    const RigUnits units{description.displacement_unit(), description.force_unit()};
    auto channels = contract::auxiliary_channels_of(description);
    if (!channels) spdlog::error("auxiliary channels are left out: {}", channels.error().message);
    core_.set_rig(description.rig_id(), *geometry, description.sample_rate_Hz(), is_rotary(units),
                  channels ? std::move(*channels) : std::vector<AuxiliaryChannel>());
    units_[description.rig_id()] = units;
  }
}

void IdentificationService::take_plans() {
  for (const auto& received : runtime::drain(endpoints_.plans)) {
    const v1::SessionPlan& plan = received.value;
    if (plan.rig_id() != settings_.rig || plan.started_at() < session_started_at_) continue;
    session_started_at_ = plan.started_at();
    set_session(plan.session_id(), muscle_settings_of(plan.protocol_toml()));
    const Needs needs = needs_of(plan);
    core_.set_needed(needs.methods, needs.is_precision_led);
  }
}

void IdentificationService::take_commands() {
  for (const auto& received : runtime::drain(endpoints_.commands)) {
    const TrialPlan plan = from_wire(received.value);
    if (plan.rig != settings_.rig) continue;
    if (session_started_at_.empty() && plan.session != session_)
      set_session(plan.session);  // no plan was seen: who commands has one
    core_.expect(plan);
  }
}

void IdentificationService::take_states() {
  for (auto& received : runtime::drain(endpoints_.states)) {
    if (received.value.session_id() == session_) state_ = std::move(received.value);
  }
}

void IdentificationService::take_reviews() {
  for (auto& received : runtime::drain(endpoints_.reviews)) {
    const v1::TrialReview& review = received.value;
    if (!review.is_rejected()) continue;
    if (reviews_.size() >= kMostReviews)
      std::erase_if(reviews_, [this](const auto& known) { return known.second.session_id() != session_; });
    if (review.session_id() == session_) core_.reject(review.trial_id(), review.attempt());
    reviews_[review.trial_id()] = review;
  }
}

bool IdentificationService::is_decided(const TrialPlan& trial) const {
  return state_ && state_->session_id() == trial.session && state_->attempts() >= trial.attempt &&
         state_->trial_id() != trial.trial;
}

void IdentificationService::take_auxiliary() {
  for (const auto& received : runtime::drain(endpoints_.auxiliary)) {
    if (received.value.rig_id() == settings_.rig) {
      core_.add(from_wire(received.value));
    } else {
      ++foreign_;
    }
  }
}

void IdentificationService::set_session(const Id& session, const muscles::MuscleSettings& muscles) {
  if (session == session_ && muscles == muscles_) return;
  session_ = session;
  muscles_ = muscles;
  core_.set_session(session, muscles);
  for (const auto& [trial, review] : reviews_) {
    if (review.session_id() == session) core_.reject(trial, review.attempt());
  }
  spdlog::info("session {}", to_hex(session));
}

void IdentificationService::take_samples(Clock::TimePoint now) {
  blocks_.clear();
  has_more_samples_ = endpoints_.samples.take(blocks_, kBlocksAtOnce) == kBlocksAtOnce;
  for (const auto& received : blocks_) {
    if (received.value.rig_id() != settings_.rig) {
      ++foreign_;
      continue;
    }
    core_.add(from_wire(received.value, rows_));
  }
  if (blocks_.empty()) return;
  const auto age = now.time_since_epoch() - std::chrono::nanoseconds(blocks_.back().sample.received_ns);
  lag_ = std::max(0.0, std::chrono::duration<double>(age).count());
}

void IdentificationService::take_outcomes(Clock::TimePoint now) {
  for (const auto& received : runtime::drain(endpoints_.outcomes)) {
    if (received.value.program().rig_id() != settings_.rig) {
      ++foreign_;
      continue;
    }
    core_.add(from_wire(received.value), now);
  }
}

void IdentificationService::publish(const IdentificationCore::Output& output) {
  for (const std::string& remark : output.remarks) spdlog::warn("{}", remark);
  for (const auto& judged : output.verdicts) {
    const auto level = judged.verdict.is_valid ? spdlog::level::debug : spdlog::level::info;
    spdlog::log(level, "trial {}: {}", judged.report.plan.attempt, judged.verdict.detail);
    const auto& defects = judged.verdict.defects;
    const bool has_gap = std::find(defects.begin(), defects.end(), Defect::kGap) != defects.end();
    if (has_gap && is_decided(judged.report.plan)) continue;  // by the verdict that the scheduler had
    if (verdicts_.size() >= kMostVerdictsHeld) {
      spdlog::error("the verdict on trial {} is given up: {} are unsent", verdicts_.front().attempt(),
                    verdicts_.size());
      verdicts_.pop_front();
    }
    verdicts_.push_back(to_wire(judged.report, judged.verdict));
  }
  for (const ConditionEstimate& estimate : output.estimates) {
    if (!estimate.refusal.empty())
      spdlog::warn("{} is not identified: {}", estimate.condition.posture, estimate.refusal);
    v1::Estimate wire = to_wire(estimate, units_of(estimate.condition.rig));
    const Id id = wire.estimate_id();
    estimates_.insert_or_assign(id, std::move(wire));
  }
  for (const ResendRequest& request : output.requests) {
    spdlog::debug("rows {} to {} are missing and asked for", request.range.first, request.range.last());
    // One that is not sent is repeated by the core.
    if (auto sent = endpoints_.resends.write(to_wire(request)); !sent) {
      spdlog::warn("a request for rows is not sent: {}", sent.error().message);
    }
  }
}

void IdentificationService::publish_live() {
  if (has_more_samples_) return;  // behind: one estimate answers them all
  const Clock::TimePoint begun = clock_.now();
  const auto estimate = core_.live(begun);
  if (!estimate) return;
  // For eyes only: the next one follows.
  if (auto sent = endpoints_.live.write(to_wire(*estimate, units_of(estimate->condition.rig))); !sent) {
    spdlog::debug("a live estimate is not sent: {}", sent.error().message);
  }
  core_.charge_live(clock_.now() - begun);
}

void IdentificationService::flush() {
  while (!verdicts_.empty()) {
    if (auto sent = endpoints_.verdicts.write(verdicts_.front()); !sent) {
      spdlog::warn("the verdict on trial {} is not taken yet: {}", verdicts_.front().attempt(),
                   sent.error().message);
      return;
    }
    verdicts_.pop_front();
  }
  while (!estimates_.empty()) {
    if (auto sent = endpoints_.estimates.write(estimates_.begin()->second); !sent) {
      spdlog::warn("an estimate is not taken yet: {}", sent.error().message);
      return;
    }
    estimates_.erase(estimates_.begin());
  }
}

std::string IdentificationService::why_not_ready() {
  roster_.update();
  if (auto missing = roster_.missing({v1::ROLE_RIG}, false); !missing.empty()) return missing;
  if (!units_.contains(settings_.rig)) return "the rig's description is not there";
  if (endpoints_.samples.status().matched_writers == 0) return "the rig's samples are not connected";
  if (endpoints_.outcomes.status().matched_writers == 0) return "the rig's outcomes are not connected";
  if (endpoints_.resends.status().matched_readers == 0) return "the rig does not hear requests";
  return {};
}

void IdentificationService::report_health() {
  const std::string why_not = why_not_ready();
  const std::size_t waiting = core_.assembler().waiting().size();
  std::string state = why_not;
  if (state.empty()) {
    state = waiting > 1 ? fmt::format("{} trials wait for samples", waiting) : "ready";
    if (!settings_.served.empty()) state += "; one process serves " + settings_.served;
  }
  health_.set_state(why_not.empty(), state);
  const AssemblerCounts& counts = core_.assembler().counts();
  const std::uint64_t dropped =
      counts.refused + counts.reports_dropped + endpoints_.samples.status().malformed;
  health_.set_load(lag_, static_cast<std::uint32_t>(std::min<std::size_t>(core_.queue_depth(), UINT32_MAX)),
                   dropped);
}

RigUnits IdentificationService::units_of(const Id& rig) const {
  const auto units = units_.find(rig);
  return units == units_.end() ? RigUnits{} : units->second;
}

}  // namespace tonus::identification
