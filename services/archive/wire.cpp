#include "services/archive/wire.hpp"

#include <spdlog/fmt/fmt.h>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/contract/names.hpp"
#include "services/contract/rig.hpp"
#include "services/core/crc32c.hpp"
#include "services/store/block_header.hpp"
#include "services/store/wire.hpp"

namespace tonus::archive {
namespace {

template <typename Count>
void put_counts(const store::Certificate& counts, Count& wire) {
  wire.expected_samples(counts.expected);
  wire.received_samples(counts.received);
  wire.resent_samples(counts.resent);
  wire.duplicated_samples(counts.duplicated);
  wire.missing_samples(counts.missing);
}

/// The session that a message says it belongs to; none where it names none.
template <typename T>
Id session_named_by(const T& value) {
  if constexpr (requires { value.session_id(); }) return value.session_id();
  if constexpr (requires { value.program().session_id(); }) return value.program().session_id();
  return kNoId;
}

Result<void> feed_samples(Ingest& ingest, const bus::Sample& sample, std::uint64_t received_utc_ns) {
  TONUS_TRY_ASSIGN(auto block, store::read_block_header(*sample.payload));
  block.received_ns = received_utc_ns;
  block.checksum = crc32c(*sample.payload);
  block.payload = sample.payload;
  ingest.take(std::move(block));
  return {};
}

Result<void> feed_auxiliary(Ingest& ingest, const bus::Sample& sample, std::uint64_t received_utc_ns) {
  TONUS_TRY_ASSIGN(auto header, store::read_auxiliary_header(*sample.payload));
  header.block.received_ns = received_utc_ns;
  header.block.checksum = crc32c(*sample.payload);
  header.block.payload = sample.payload;
  return ingest.take_auxiliary(std::move(header.block), header.values_per_sample);
}

/// Reads what matters here in a message of any other topic.
Result<void> note(Ingest& ingest, const bus::TopicSpec& topic, const bus::Sample& sample) {
  if (topic.name == topics::kTrialOutcome.spec.name) {
    TONUS_TRY_ASSIGN(const auto wire, bus::decode<v1::TrialOutcome>(*sample.payload));
    TONUS_TRY_ASSIGN(const auto record, store::to_record(wire));
    ingest.note_outcome(record);
  } else if (topic.name == topics::kRigState.spec.name) {
    TONUS_TRY_ASSIGN(const auto wire, bus::decode<v1::RigState>(*sample.payload));
    if (wire.next_sequence() > store::kLargestSequence || wire.received_through() > wire.next_sequence()) {
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("rig/state: received_through {} and next_sequence {} are not allowed",
                              wire.received_through(), wire.next_sequence()));
    }
    ingest.note_rig(to_report(wire));
  } else if (topic.name == topics::kRigDescription.spec.name) {
    TONUS_TRY_ASSIGN(const auto wire, bus::decode<v1::RigDescription>(*sample.payload));
    TONUS_TRY_ASSIGN(const auto channels, contract::auxiliary_channels_of(wire));
    const std::size_t values = values_per_sample(channels, wire.sample_rate_Hz());
    ingest.note_auxiliary(wire.rig_id(), static_cast<std::uint32_t>(values));
  } else if (topic.name == topics::kSessionPlan.spec.name) {
    TONUS_TRY_ASSIGN(const auto wire, bus::decode<v1::SessionPlan>(*sample.payload));
    ingest.note_plan(store::to_record(wire));
  } else if (topic.name == topics::kSessionState.spec.name) {
    TONUS_TRY_ASSIGN(const auto wire, bus::decode<v1::SessionState>(*sample.payload));
    if (v1::is_over(wire.phase())) ingest.note_session_end(wire.session_id(), wire.phase());
  }
  return {};
}

}  // namespace

bool is_kept(const bus::TopicSpec& topic) {
  const auto is = [&topic](const bus::TopicSpec& other) { return topic.name == other.name; };
  const bool is_own = is(topics::kArchiveReceipt.spec);
  const bool is_clock_traffic = is(topics::kClockProbe.spec) || is(topics::kClockEcho.spec);
  return topic.qos.reliable && !is_own && !is_clock_traffic;
}

Result<void> feed(Ingest& ingest, const bus::TopicSpec& topic, const bus::Sample& sample,
                  std::uint64_t received_utc_ns) {
  if (topic.name == topics::kRigSamples.spec.name) return feed_samples(ingest, sample, received_utc_ns);
  if (topic.name == topics::kRigAuxiliary.spec.name) return feed_auxiliary(ingest, sample, received_utc_ns);
  Id session = kNoId;
  TONUS_TRY(topics::decode_any(topic, *sample.payload,
                               [&session](const auto& value) { session = session_named_by(value); }));
  auto noted = note(ingest, topic, sample);
  const bool is_state = topic.qos.durability == bus::Durability::kTransientLocal;
  ingest.take(store::Message{std::string(topic.name), sample.key, session, received_utc_ns,
                             crc32c(*sample.payload), sample.payload},
              is_state);
  return noted;
}

RigReport to_report(const v1::RigState& wire) {
  const bool is_faulted = wire.fault_bits() != 0 || wire.mode() == v1::RIG_HELD;
  return {{wire.rig_id(), wire.epoch()}, wire.next_sequence(), wire.received_through(), is_faulted};
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
  // What it speaks of: a rig that has no receipt for what comes before takes none for this.
  wire.expected_samples(receipt.through - receipt.first);
  wire.received_samples(receipt.through - receipt.first);
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

v1::ArchiveReceipt to_wire(const store::SessionCertificate& certificate) {
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
