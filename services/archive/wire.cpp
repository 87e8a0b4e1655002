#include "services/archive/wire.hpp"

#include <spdlog/fmt/fmt.h>

#include "idl/topics.hpp"
#include "services/archive/block_header.hpp"
#include "services/bus/typed.hpp"
#include "services/core/crc32c.hpp"

namespace tonus::archive {
namespace {

template <typename Count>
void put_counts(const Certificate& counts, Count& wire) {
  wire.expected_samples(counts.expected);
  wire.received_samples(counts.received);
  wire.resent_samples(counts.resent);
  wire.duplicated_samples(counts.duplicated);
  wire.missing_samples(counts.missing);
}

Result<void> feed_samples(Ingest& ingest, const bus::Sample& sample, std::uint64_t received_utc_ns) {
  auto block = read_block_header(*sample.payload);
  if (!block) return block.error();
  block->received_ns = received_utc_ns;
  block->checksum = crc32c(*sample.payload);
  block->payload = sample.payload;
  ingest.take(std::move(*block));
  return {};
}

/// Reads what matters here in a message of any other topic.
Result<void> note(Ingest& ingest, const bus::TopicSpec& topic, const bus::Sample& sample) {
  if (topic.name == topics::kTrialOutcome.spec.name) {
    const auto wire = bus::decode<v1::TrialOutcome>(*sample.payload);
    if (!wire) return wire.error();
    const auto record = to_record(*wire);
    if (!record) return record.error();
    ingest.note_outcome(*record);
  } else if (topic.name == topics::kRigState.spec.name) {
    const auto wire = bus::decode<v1::RigState>(*sample.payload);
    if (!wire) return wire.error();
    if (wire->next_sequence() > kLargestSequence || wire->received_through() > wire->next_sequence()) {
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("rig/state: received_through {} and next_sequence {} are not allowed",
                              wire->received_through(), wire->next_sequence()));
    }
    ingest.note_rig(to_report(*wire));
  } else if (topic.name == topics::kSessionPlan.spec.name) {
    const auto wire = bus::decode<v1::SessionPlan>(*sample.payload);
    if (!wire) return wire.error();
    ingest.note_plan(to_record(*wire));
  } else if (topic.name == topics::kSessionState.spec.name) {
    const auto wire = bus::decode<v1::SessionState>(*sample.payload);
    if (!wire) return wire.error();
    if (has_ended(wire->phase())) ingest.note_session_end(wire->session_id(), wire->phase());
  }
  return {};
}

}  // namespace

bool has_ended(v1::SessionPhase phase) {
  return phase == v1::SESSION_COMPLETED || phase == v1::SESSION_ABORTED || phase == v1::SESSION_FAILED;
}

bool is_kept(const bus::TopicSpec& topic) {
  const auto is = [&topic](const bus::TopicSpec& other) { return topic.name == other.name; };
  const bool is_own = is(topics::kArchiveReceipt.spec);
  const bool is_clock_traffic = is(topics::kClockProbe.spec) || is(topics::kClockEcho.spec);
  return topic.qos.reliable && !is_own && !is_clock_traffic;
}

Result<void> feed(Ingest& ingest, const bus::TopicSpec& topic, const bus::Sample& sample,
                  std::uint64_t received_utc_ns) {
  if (topic.name == topics::kRigSamples.spec.name) return feed_samples(ingest, sample, received_utc_ns);
  auto noted = note(ingest, topic, sample);
  const bool is_state = topic.qos.durability == bus::Durability::kTransientLocal;
  ingest.take(
      Message{
          std::string(topic.name), sample.key, {}, received_utc_ns, crc32c(*sample.payload), sample.payload},
      is_state);
  return noted;
}

Result<TrialRecord> to_record(const v1::TrialOutcome& wire) {
  TrialRecord record;
  record.has_samples = wire.end() != v1::TRIAL_REFUSED;
  if (record.has_samples && (wire.last_sequence() < wire.first_sequence() ||
                             wire.last_sequence() > kLargestSequence || wire.epoch() > kLargestSequence)) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format(
            "trial/outcome of attempt {}: samples {} to {} are not allowed: the last is before the first or "
            "over {}",
            wire.program().attempt(), wire.first_sequence(), wire.last_sequence(), kLargestSequence));
  }
  record.trial = wire.trial_id();
  record.session = wire.program().session_id();
  record.stream = {wire.program().rig_id(), wire.epoch()};
  record.attempt = wire.program().attempt();
  record.planned_index = wire.program().planned_index();
  record.posture = wire.program().posture();
  record.set = wire.program().set_number();
  record.end = wire.end();
  record.first_sequence = wire.first_sequence();
  record.onset_sequence = wire.onset_sequence();
  record.last_sequence = wire.last_sequence();
  record.sample_rate = wire.sample_rate_Hz();
  return record;
}

SessionRecord to_record(const v1::SessionPlan& wire) {
  return {wire.session_id(), wire.rig_id(),         wire.subject(),    wire.protocol_name(),
          wire.seed(),       wire.planned_trials(), wire.started_at(), wire.software_version()};
}

RigReport to_report(const v1::RigState& wire) {
  return {{wire.rig_id(), wire.epoch()}, wire.next_sequence(), wire.received_through()};
}

v1::ArchiveReceipt to_wire(const StreamReceipt& receipt) {
  v1::ArchiveReceipt wire;
  wire.subject_id(receipt.stream.rig);
  wire.kind(v1::RECEIPT_STREAM);
  wire.rig_id(receipt.stream.rig);
  wire.session_id(receipt.session);
  wire.epoch(receipt.stream.epoch);
  wire.through_sequence(receipt.through);
  put_counts(receipt.counts, wire);
  return wire;
}

v1::ArchiveReceipt to_wire(const TrialReceipt& receipt) {
  v1::ArchiveReceipt wire;
  wire.subject_id(receipt.trial);
  wire.kind(v1::RECEIPT_TRIAL);
  wire.rig_id(receipt.stream.rig);
  wire.session_id(receipt.session);
  wire.epoch(receipt.stream.epoch);
  wire.through_sequence(receipt.through);
  put_counts(receipt.certificate, wire);
  return wire;
}

v1::ArchiveReceipt to_wire(const SessionCertificate& certificate) {
  v1::ArchiveReceipt wire;
  wire.subject_id(certificate.session);
  wire.kind(v1::RECEIPT_SESSION);
  wire.rig_id(certificate.rig);
  wire.session_id(certificate.session);
  put_counts(certificate.sums, wire);
  return wire;
}

v1::ArchiveResend to_wire(const ResendRequest& request) {
  v1::ArchiveResend wire;
  wire.rig_id(request.stream.rig);
  wire.epoch(request.stream.epoch);
  wire.first_sequence(request.range.first);
  wire.last_sequence(request.range.end - 1);
  wire.requested_by("archive");
  return wire;
}

}  // namespace tonus::archive
