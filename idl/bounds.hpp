#pragma once

#include <string>

#include <idl/archive.h>
#include <idl/estimate.h>
#include <idl/rig.h>
#include <idl/service.h>
#include <idl/session.h>
#include <idl/trial.h>

/// Bounds that the .idl files state and the generated code does not check. Encoding and decoding ask these
/// functions; the answer is empty where a value is within its bounds. Enumerations from a newer contract are
/// refused here too.
namespace tonus::v1 {

[[nodiscard]] inline std::string out_of_bounds(const char* what, std::size_t value, std::size_t limit) {
  return std::string(what) + " is " + std::to_string(value) + ", at most " + std::to_string(limit) +
         " is allowed";
}

[[nodiscard]] inline std::string bounds_violation(const SampleBlock& block) {
  if (block.samples().size() > 256) return out_of_bounds("SampleBlock.samples", block.samples().size(), 256);
  return {};
}

[[nodiscard]] inline std::string bounds_violation(const FlightRecord& record) {
  if (record.cycles().size() > 256) return out_of_bounds("FlightRecord.cycles", record.cycles().size(), 256);
  return {};
}

[[nodiscard]] inline std::string bounds_violation(const RigDescription& rig) {
  if (rig.limits_off().size() > 16)
    return out_of_bounds("RigDescription.limits_off", rig.limits_off().size(), 16);
  return {};
}

[[nodiscard]] inline std::string bounds_violation(const ServiceHealth& health) {
  if (health.warnings().size() > 16)
    return out_of_bounds("ServiceHealth.warnings", health.warnings().size(), 16);
  return {};
}

[[nodiscard]] inline std::string bounds_violation(const ArchiveReceipt& receipt) {
  if (receipt.kind() > RECEIPT_SESSION)
    return out_of_bounds("ArchiveReceipt.kind", receipt.kind(), RECEIPT_SESSION);
  return {};
}

[[nodiscard]] inline std::string bounds_violation(const TrialOutcome& outcome) {
  if (outcome.end() > TRIAL_BROKEN_OFF)
    return out_of_bounds("TrialOutcome.end", outcome.end(), TRIAL_BROKEN_OFF);
  return {};
}

[[nodiscard]] inline std::string bounds_violation(const TrialVerdict& verdict) {
  if (verdict.reasons().size() > 16)
    return out_of_bounds("TrialVerdict.reasons", verdict.reasons().size(), 16);
  return {};
}

[[nodiscard]] inline std::string bounds_violation(const Estimate& estimate) {
  if (estimate.reasons().size() > 16) return out_of_bounds("Estimate.reasons", estimate.reasons().size(), 16);
  if (estimate.trials().size() > 1024)
    return out_of_bounds("Estimate.trials", estimate.trials().size(), 1024);
  if (estimate.checks().size() > 16) return out_of_bounds("Estimate.checks", estimate.checks().size(), 16);
  if (estimate.parameters().size() > 16)
    return out_of_bounds("Estimate.parameters", estimate.parameters().size(), 16);
  return {};
}

[[nodiscard]] inline std::string bounds_violation(const SessionPlan& plan) {
  if (plan.postures().size() > 64) return out_of_bounds("SessionPlan.postures", plan.postures().size(), 64);
  return {};
}

[[nodiscard]] inline std::string bounds_violation(const SessionState& state) {
  if (state.phase() > SESSION_FAILED)
    return out_of_bounds("SessionState.phase", state.phase(), SESSION_FAILED);
  return {};
}

[[nodiscard]] inline std::string bounds_violation(const SessionCommand& command) {
  if (command.request() > SESSION_ABORT) {
    return out_of_bounds("SessionCommand.request", command.request(), SESSION_ABORT);
  }
  return {};
}

[[nodiscard]] inline std::string bounds_violation(const RigCommand& command) {
  if (command.request() > RIG_DISARM)
    return out_of_bounds("RigCommand.request", command.request(), RIG_DISARM);
  return {};
}

}  // namespace tonus::v1
