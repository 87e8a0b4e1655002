#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "services/contract/certificate.hpp"
#include "services/contract/sequence.hpp"
#include "services/core/id.hpp"
#include "services/store/coverage.hpp"

/// What the archive holds. Times are UTC in ns; a payload is a message's bytes as they came (CDR).
namespace tonus::store {

using Payload = std::shared_ptr<const std::vector<std::byte>>;

/// Larger sequence numbers and epochs are nonsense, and there is room to add to them; 2^62.
inline constexpr std::uint64_t kLargestSequence = std::uint64_t{1} << 62U;

using tonus::Certificate;
using tonus::StreamKey;

/// One message with samples, or with what the auxiliary channels gave during them.
struct Block {
  StreamKey stream;
  std::uint64_t first_sequence = 0;
  std::uint32_t count = 0;
  Id session{};
  Id trial{};
  bool is_resent = false;
  std::uint64_t received_ns = 0;
  std::uint32_t checksum = 0;  ///< CRC-32C of the payload.
  Payload payload;
  bool is_auxiliary = false;

  [[nodiscard]] SequenceRange range() const { return {first_sequence, first_sequence + count}; }
};

/// One message of any other topic.
struct Message {
  std::string topic;
  Id key{};
  Id session{};  ///< In force when it came; zero: none yet.
  std::uint64_t received_ns = 0;
  std::uint32_t checksum = 0;
  Payload payload;
};

/// What tells a message from the one before it of the same topic and key.
struct MessageDigest {
  std::string topic;
  Id key{};
  std::uint32_t checksum = 0;
  std::uint64_t bytes = 0;
};

/// What is known of a stream. Every sample below `origin` was in another archive's care before this one saw
/// the stream.
struct StreamRecord {
  StreamKey key;
  std::uint64_t origin = 0;
  Coverage coverage;
  std::uint64_t resent = 0;      ///< Samples that came first in a resent block.
  std::uint64_t duplicated = 0;  ///< Samples that came when they were there already.

  /// Values of the auxiliary channels with each sample; 0: the rig describes none. A sample with auxiliary
  /// values is whole where both coverages have it.
  std::uint32_t auxiliary_values = 0;
  Coverage auxiliary_coverage{};

  [[nodiscard]] Coverage whole() const {
    return auxiliary_values == 0 ? coverage : coverage.common(auxiliary_coverage);
  }
};

/// A session's plan, decoded where others may want to search.
struct SessionRecord {
  Id session{};
  Id rig{};
  std::string subject;
  std::string protocol_name;
  std::uint64_t seed = 0;
  std::uint32_t planned_trials = 0;
  std::string started_at;  ///< ISO 8601, UTC.
  std::string software_version;
};

/// Resent and duplicated samples of a trial that is not certified yet.
struct TrialTally {
  Id trial{};
  std::uint64_t resent = 0;
  std::uint64_t duplicated = 0;
};

/// A trial's outcome and certificate.
struct TrialRecord {
  Id trial{};
  Id session{};
  StreamKey stream;
  std::uint32_t attempt = 0;
  std::uint32_t planned_index = 0;
  std::string posture;
  std::int32_t set = 0;
  std::uint32_t end = 0;    ///< v1::TrialEnd
  bool has_samples = true;  ///< False for a trial that never began: the sequences mean nothing.
  std::uint64_t first_sequence = 0;
  std::uint64_t onset_sequence = 0;
  std::uint64_t last_sequence = 0;  ///< Belongs to the trial.
  double sample_rate = 0.0;         ///< Hz
  Certificate certificate;
  bool is_certified = false;  ///< The range is whole and on the disk.
  std::uint64_t certified_ns = 0;

  [[nodiscard]] SequenceRange range() const {
    return has_samples ? SequenceRange{first_sequence, last_sequence + 1} : SequenceRange{};
  }
};

/// The sums over a session's trials, made when the session has ended.
struct SessionCertificate {
  Id session{};
  Id rig{};
  std::uint32_t end = 0;     ///< v1::SessionPhase
  std::uint32_t trials = 0;  ///< Attempts with an outcome.
  std::uint32_t incomplete_trials = 0;
  Certificate sums;
  std::uint64_t certified_ns = 0;

  /// Counts one attempt in.
  void add(const TrialRecord& trial) {
    rig = trial.stream.rig;
    ++trials;
    incomplete_trials += trial.is_certified ? 0 : 1;
    sums += trial.certificate;
  }
};

/// What becomes durable in one step, all of it or nothing.
struct Batch {
  std::vector<Block> blocks;
  std::vector<Message> messages;
  std::vector<SessionRecord> sessions;           ///< Replace what is known of the same session.
  std::vector<StreamRecord> streams;             ///< Replace what is known of the same stream.
  std::vector<TrialTally> tallies;               ///< Replace what is known of the same trial.
  std::vector<TrialRecord> trials;               ///< As above; a certified trial needs no tally any more.
  std::vector<SessionCertificate> certificates;  ///< Replace what is known of the same session.

  [[nodiscard]] bool is_empty() const {
    return blocks.empty() && messages.empty() && sessions.empty() && streams.empty() && tallies.empty() &&
           trials.empty() && certificates.empty();
  }
};

}  // namespace tonus::store
