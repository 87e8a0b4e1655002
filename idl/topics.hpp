#pragma once

#include <array>
#include <span>
#include <string>
#include <tuple>

#include "idl/bounds.hpp"
#include "services/bus/bus.hpp"
#include "services/bus/typed.hpp"

#include <idl/archive.h>
#include <idl/estimate.h>
#include <idl/rig.h>
#include <idl/service.h>
#include <idl/session.h>
#include <idl/trial.h>

/// The one table of topics: name, type and quality of service of everything on the bus. A topic more is a
/// line here and a type in an .idl file. Who writes and reads each one is in this folder's README.
namespace tonus::topics {

namespace qos {
using std::chrono::milliseconds;

/// The last value of each key, also for late joiners.
inline constexpr bus::Qos kLatest{.reliable = true,
                                  .durability = bus::Durability::kTransientLocal,
                                  .history = bus::History::kKeepLast,
                                  .depth = 1,
                                  .max_blocking = milliseconds(1000)};

/// As kLatest, and its writer's death is noticed within the lease.
inline constexpr bus::Qos kAlive{.reliable = true,
                                 .durability = bus::Durability::kTransientLocal,
                                 .history = bus::History::kKeepLast,
                                 .depth = 1,
                                 .liveliness_lease = milliseconds(500),
                                 .max_blocking = milliseconds(1000)};

/// Every message, to current readers only; a full history is an error to the sender, which retries.
inline constexpr bus::Qos kRequest{.reliable = true,
                                   .durability = bus::Durability::kVolatile,
                                   .history = bus::History::kKeepAll,
                                   .depth = 256,
                                   .max_blocking = milliseconds(200)};

/// Blocks of samples: every one to current readers, with back-pressure; the rig's spool fills what is
/// missing.
inline constexpr bus::Qos kStream{.reliable = true,
                                  .durability = bus::Durability::kVolatile,
                                  .history = bus::History::kKeepAll,
                                  .depth = 1000,
                                  .max_blocking = milliseconds(20)};

/// Best effort: an old value is worth nothing.
inline constexpr bus::Qos kLive{.reliable = false,
                                .durability = bus::Durability::kVolatile,
                                .history = bus::History::kKeepLast,
                                .depth = 1};
}  // namespace qos

template <typename T>
using Topic = bus::Topic<T>;

inline constexpr Topic<v1::RigDescription> kRigDescription{
    {"rig/description", "tonus::v1::RigDescription", qos::kLatest, 4096}};
inline constexpr Topic<v1::RigState> kRigState{{"rig/state", "tonus::v1::RigState", qos::kAlive, 4096}};
inline constexpr Topic<v1::SampleBlock> kRigSamples{
    {"rig/samples", "tonus::v1::SampleBlock", qos::kStream, 32768}};
inline constexpr Topic<v1::AuxiliaryBlock> kRigAuxiliary{
    {"rig/auxiliary", "tonus::v1::AuxiliaryBlock", qos::kStream, 60000}};
inline constexpr Topic<v1::RigTiming> kRigTiming{{"rig/timing", "tonus::v1::RigTiming", qos::kLatest, 4096}};
inline constexpr Topic<v1::FlightRecord> kRigFlightRecord{
    {"rig/flight_record", "tonus::v1::FlightRecord", qos::kLatest, 60000}};
inline constexpr Topic<v1::RigCommand> kRigCommand{
    {"rig/command", "tonus::v1::RigCommand", qos::kRequest, 4096}};
inline constexpr Topic<v1::RigReply> kRigReply{{"rig/reply", "tonus::v1::RigReply", qos::kRequest, 4096}};
inline constexpr Topic<v1::RigStop> kRigStop{{"rig/stop", "tonus::v1::RigStop", qos::kLive, 1024}};
/// A stop as it was given, once the rig's loop shows it.
inline constexpr Topic<v1::RigStop> kRigStopped{{"rig/stopped", "tonus::v1::RigStop", qos::kLive, 1024}};
inline constexpr Topic<v1::RigLease> kRigLease{{"rig/lease", "tonus::v1::RigLease", qos::kLive, 256}};
inline constexpr Topic<v1::TrialCommand> kTrialCommand{
    {"trial/command", "tonus::v1::TrialCommand", qos::kRequest, 4096}};
inline constexpr Topic<v1::TrialOutcome> kTrialOutcome{
    {"trial/outcome", "tonus::v1::TrialOutcome", qos::kLatest, 4096}};
inline constexpr Topic<v1::TrialVerdict> kTrialVerdict{
    {"trial/verdict", "tonus::v1::TrialVerdict", qos::kLatest, 4096}};
inline constexpr Topic<v1::TrialReview> kTrialReview{
    {"trial/review", "tonus::v1::TrialReview", qos::kLatest, 4096}};
inline constexpr Topic<v1::Estimate> kEstimateLive{
    {"estimate/live", "tonus::v1::Estimate", qos::kLive, 60000}};
inline constexpr Topic<v1::Estimate> kEstimateCondition{
    {"estimate/condition", "tonus::v1::Estimate", qos::kLatest, 60000}};
inline constexpr Topic<v1::SessionPlan> kSessionPlan{
    {"session/plan", "tonus::v1::SessionPlan", qos::kLatest, 60000}};
inline constexpr Topic<v1::SessionState> kSessionState{
    {"session/state", "tonus::v1::SessionState", qos::kLatest, 60000}};
inline constexpr Topic<v1::SessionCommand> kSessionCommand{
    {"session/command", "tonus::v1::SessionCommand", qos::kRequest, 60000}};
inline constexpr Topic<v1::SessionReply> kSessionReply{
    {"session/reply", "tonus::v1::SessionReply", qos::kRequest, 8192}};
/// Every note of a session, to late joiners too.
inline constexpr Topic<v1::SessionNote> kSessionNote{
    {"session/note", "tonus::v1::SessionNote", qos::kLatest, 8192}};
inline constexpr Topic<v1::SessionCue> kSessionCue{
    {"session/cue", "tonus::v1::SessionCue", qos::kLatest, 4096}};
inline constexpr Topic<v1::ArchiveReceipt> kArchiveReceipt{
    {"archive/receipt", "tonus::v1::ArchiveReceipt", qos::kLatest, 4096}};
inline constexpr Topic<v1::ArchiveResend> kArchiveResend{
    {"archive/resend", "tonus::v1::ArchiveResend", qos::kRequest, 4096}};
inline constexpr Topic<v1::ServiceHealth> kServiceHealth{
    {"service/health", "tonus::v1::ServiceHealth", qos::kAlive, 8192}};
inline constexpr Topic<v1::ServiceConfiguration> kServiceConfiguration{
    {"service/configuration", "tonus::v1::ServiceConfiguration", qos::kLatest, 60000}};
inline constexpr Topic<v1::ClockProbe> kClockProbe{
    {"clock/probe", "tonus::v1::ClockProbe", qos::kRequest, 4096}};
inline constexpr Topic<v1::ClockEcho> kClockEcho{{"clock/echo", "tonus::v1::ClockEcho", qos::kRequest, 4096}};
inline constexpr Topic<v1::ClockOffset> kClockOffset{
    {"clock/offset", "tonus::v1::ClockOffset", qos::kLatest, 4096}};

/// Every topic with its type.
inline constexpr std::tuple kTyped{
    kRigDescription,       kRigState,          kRigSamples,     kRigTiming,     kRigFlightRecord,
    kRigCommand,           kRigReply,          kTrialCommand,   kTrialOutcome,  kTrialVerdict,
    kEstimateLive,         kEstimateCondition, kSessionPlan,    kSessionState,  kSessionCommand,
    kSessionReply,         kSessionCue,        kArchiveReceipt, kArchiveResend, kServiceHealth,
    kServiceConfiguration, kClockProbe,        kClockEcho,      kClockOffset,   kRigStop,
    kRigStopped,           kRigLease,          kRigAuxiliary,   kTrialReview,   kSessionNote};

/// Every topic, for programs that carry bytes without reading them.
inline constexpr std::array kAll =
    std::apply([](const auto&... topic) { return std::array{topic.spec...}; }, kTyped);

/// Calls `visit` with the value that the payload holds. kInvalidArgument, and no call, unless it is exactly
/// one value of the topic's type within its bounds.
template <typename Visit>
[[nodiscard]] Result<void> decode_any(const bus::TopicSpec& topic, std::span<const std::byte> payload,
                                      const Visit& visit) {
  Result<void> outcome = fail(ErrorCode::kInvalidArgument,
                              "topic '" + std::string(topic.name) + "' is not in the table of topics");
  const auto decode_as = [&]<typename T>(const Topic<T>& known) {
    if (known.spec.name != topic.name) return;
    const auto value = bus::decode<T>(payload);
    outcome = value ? Result<void>() : Result<void>(value.error());
    if (value) visit(*value);
  };
  std::apply([&decode_as](const auto&... known) { (decode_as(known), ...); }, kTyped);
  return outcome;
}

}  // namespace tonus::topics
