#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "services/core/crc32c.hpp"
#include "services/store/records.hpp"

/// Made-up records for the archive's tests.
namespace tonus::store::testing {

inline const Id kRig = id_of("rig");
inline const Id kSession = id_of("session");
inline constexpr std::uint64_t kEpoch = 1'700'000'000'000'000'000;
inline const StreamKey kStream{kRig, kEpoch};

inline Payload payload_of(const std::string& text) {
  const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
  return std::make_shared<const std::vector<std::byte>>(bytes, bytes + text.size());
}

inline Block block_of(std::uint64_t first, std::uint32_t count, const Id& trial = kNoId,
                      bool is_resent = false, const StreamKey& stream = kStream) {
  Block block;
  block.stream = stream;
  block.first_sequence = first;
  block.count = count;
  block.session = kSession;
  block.trial = trial;
  block.is_resent = is_resent;
  block.received_ns = 5;
  block.payload = payload_of("samples " + std::to_string(first) + "+" + std::to_string(count));
  block.checksum = crc32c(*block.payload);
  return block;
}

inline Block auxiliary_block_of(std::uint64_t first, std::uint32_t count, const Id& trial = kNoId,
                                bool is_resent = false, const StreamKey& stream = kStream) {
  Block block = block_of(first, count, trial, is_resent, stream);
  block.is_auxiliary = true;
  block.payload = payload_of("values of " + std::to_string(first) + "+" + std::to_string(count));
  block.checksum = crc32c(*block.payload);
  return block;
}

inline Message message_of(const std::string& topic, const Id& key, const std::string& text) {
  Message message{topic, key, {}, 7, 0, payload_of(text)};
  message.checksum = crc32c(*message.payload);
  return message;
}

inline TrialRecord trial_of(std::uint32_t attempt, std::uint64_t first, std::uint64_t last) {
  TrialRecord trial;
  trial.trial = trial_id(kSession, attempt);
  trial.session = kSession;
  trial.stream = kStream;
  trial.attempt = attempt;
  trial.planned_index = attempt - 1;
  trial.posture = "reference";
  trial.set = 1;
  trial.first_sequence = first;
  trial.onset_sequence = first;
  trial.last_sequence = last;
  trial.sample_rate = 200.0;
  return trial;
}

inline SessionRecord session_of(const Id& id, const std::string& started_at) {
  return {id, kRig, "subject's name", "unloaded", 18'446'744'073'709'551'615U, 80, started_at, "0.1.0"};
}

}  // namespace tonus::store::testing
