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

/// Whether the archive keeps a topic: everything but best-effort topics and its own receipts, whose
/// content its tables have.
[[nodiscard]] bool is_kept(const bus::TopicSpec& topic);

/// Hands one message to the core. kInvalidArgument where it is not exactly one value of its type within its
/// bounds: it is then left out. Where its values contradict each other, it is stored and nothing follows from
/// it.
[[nodiscard]] Result<void> feed(Ingest& ingest, const bus::TopicSpec& topic, const bus::Sample& sample,
                                std::uint64_t received_utc_ns);

[[nodiscard]] RigReport to_report(const v1::RigState& wire);

[[nodiscard]] v1::ArchiveReceipt to_wire(const StreamReceipt& receipt);
[[nodiscard]] v1::ArchiveReceipt to_wire(const TrialReceipt& receipt);
[[nodiscard]] v1::ArchiveReceipt to_wire(const store::SessionCertificate& certificate);
[[nodiscard]] v1::ArchiveResend to_wire(const ResendRequest& request);

}  // namespace tonus::archive
