#include "rig_agent/agent/rig_service.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "idl/topics.hpp"
#include "rig_agent/agent/hold_reason.hpp"

namespace tonus::rig {
namespace {

/// A computed rig is held up by the machine, not by a device.
Clock::Duration longest_cycle(const drivers::Capabilities& driver) {
  return driver.moves_nothing_real ? std::chrono::milliseconds(5000) : std::chrono::milliseconds(100);
}

Publisher::Options publishing(Rig& rig, std::uint64_t epoch, bool is_paced) {
  Publisher::Options options{
      .rig = rig.names().id, .epoch = epoch, .auxiliary_values = rig.loop().auxiliary_values()};
  if (!is_paced) options.patience = std::chrono::seconds(2);
  return options;
}

std::vector<std::string> warnings_of(const RigNames& names, const drivers::Capabilities& driver) {
  std::vector<std::string> warnings;
  if (names.resumes_unattended) warnings.emplace_back("goes on by itself after a fault or a restart");
  if (driver.actuates && !driver.moves_nothing_real && !driver.can_disable)
    warnings.emplace_back("no watchdog: the driver cannot be disabled from outside (version 1)");
  for (const auto& limit : names.limits_off) warnings.push_back("limit " + limit + " is off");
  return warnings;
}

std::string state_line(const std::string& state, const std::string& refusal) {
  return refusal.empty() ? state : state + "; " + refusal;
}

}  // namespace

Result<std::unique_ptr<RigService>> RigService::create(bus::Bus& bus, std::unique_ptr<bus::Bus> safety_bus,
                                                       const std::shared_ptr<bus::Notifier>& notifier,
                                                       runtime::HealthReporter health,
                                                       const RigServiceParts& parts,
                                                       const RigServiceOptions& options) {
  SampleWriters writers;
  TONUS_TRY_ASSIGN(writers.samples, bus.create_writer(topics::kRigSamples.spec));
  TONUS_TRY_ASSIGN(writers.auxiliary, bus.create_writer(topics::kRigAuxiliary.spec));
  TONUS_TRY_ASSIGN(auto endpoints, AgentEndpoints::create(bus, notifier));
  const std::uint64_t epoch = parts.clock.utc_ns();
  std::unique_ptr<RigService> service(
      new RigService(std::move(health), parts, epoch, std::move(writers), bus, options));
  const RigNames& names = parts.rig.names();
  TONUS_TRY_ASSIGN(service->safety_channel_,
                   SafetyChannel::create(std::move(safety_bus), names.id, parts.rig.loop(), service->lease_,
                                         service->stops_, parts.clock, notifier, options.safety));
  service->agent_.emplace(
      AgentOptions{.names = names,
                   .epoch = epoch,
                   .is_paced = options.is_paced,
                   .resumes_unattended = options.resumes_unattended,
                   .longest_cycle = longest_cycle(parts.rig.driver().capabilities())},
      AgentParts{parts.rig.loop(), parts.rig.driver(), parts.rig.recorded(), service->publisher_, parts.spool,
                 parts.log, parts.latch, service->lease_, service->stops_},
      std::move(endpoints), parts.clock);
  service->health_.set_warnings(warnings_of(names, parts.rig.driver().capabilities()));
  return service;
}

RigService::RigService(runtime::HealthReporter health, const RigServiceParts& parts, std::uint64_t epoch,
                       SampleWriters writers, bus::Bus& bus, const RigServiceOptions& options)
    : parts_(parts),
      bus_(bus),
      epoch_(epoch),
      health_(std::move(health)),
      publisher_(publishing(parts.rig, epoch, options.is_paced), parts.spool, std::move(writers.samples),
                 std::move(writers.auxiliary), parts.clock),
      lease_(parts.rig.names().id, epoch) {}

void RigService::start() { agent_->start(describe(parts_.rig.names(), parts_.rig.driver().geometry())); }

Result<void> RigService::begin(const LoopStatement& statement) {
  refusal_ = statement.refusal;
  TONUS_TRY_ASSIGN(
      auto report,
      LoopReport::create(bus_, {parts_.rig.names().id, epoch_, statement.scheduling, statement.pacer},
                         parts_.rig.loop(), parts_.clock));
  report_.emplace(std::move(report));
  return {};
}

Result<Clock::TimePoint> RigService::step(const std::string& watchdog_problem) {
  TONUS_TRY(health_.check_alone());
  if (!watchdog_problem.empty()) agent_->hold(watchdog_problem, true);
  if (const std::string doubled = health_.other(); !doubled.empty())
    agent_->hold(std::string(phrase_of(HoldReason::kSecondAgent)) + ": " + doubled, true);
  const auto due = std::min(agent_->step(), report_->step());
  const std::string why = agent_->why_not_ready();
  health_.set_state(why.empty(), state_line(why.empty() ? agent_->activity() : why, refusal_));
  health_.set_load(0.0, static_cast<std::uint32_t>(parts_.rig.loop().samples_waiting()),
                   publisher_.blocks_refused() + agent_->replies_dropped());
  return std::min(due, health_.publish_if_due());
}

}  // namespace tonus::rig
