#pragma once

#include "services/archive/ingest.hpp"
#include "services/bus/bus.hpp"
#include "services/core/result.hpp"

#include <idl/archive.h>
#include <idl/rig.h>
#include <idl/session.h>
#include <idl/trial.h>

/// Between the bus's messages and the archive's records.
namespace tonus::archive {

/// Larger sequence numbers and epochs are nonsense, and there is room to add to them; 2^62.
inline constexpr std::uint64_t kLargestSequence = std::uint64_t{1} << 62U;

/// Whether the archive keeps a topic: everything but what is for eyes only (best effort) and its own
/// receipts, whose content its tables have.
[[nodiscard]] bool is_kept(const bus::TopicSpec& topic);

/// Whether nothing more will come of a session in this phase.
[[nodiscard]] bool has_ended(v1::SessionPhase phase);

/// Hands one message to the core. kInvalidArgument where it cannot be understood: samples are then left out,
/// any other message is stored all the same.
[[nodiscard]] Result<void> feed(Ingest& ingest, const bus::TopicSpec& topic, const bus::Sample& sample,
                                std::uint64_t received_utc_ns);

[[nodiscard]] Result<TrialRecord> to_record(const v1::TrialOutcome& wire);
[[nodiscard]] SessionRecord to_record(const v1::SessionPlan& wire);
[[nodiscard]] RigReport to_report(const v1::RigState& wire);

[[nodiscard]] v1::ArchiveReceipt to_wire(const StreamReceipt& receipt);
[[nodiscard]] v1::ArchiveReceipt to_wire(const TrialReceipt& receipt);
[[nodiscard]] v1::ArchiveReceipt to_wire(const SessionCertificate& certificate);
[[nodiscard]] v1::ArchiveResend to_wire(const ResendRequest& request);

}  // namespace tonus::archive
