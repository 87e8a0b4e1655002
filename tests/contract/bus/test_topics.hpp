#pragma once

#include <cstring>

#include "services/bus/bus.hpp"

/// Topics and payloads of the bus's contract tests.
namespace tonus::bus::test {

inline constexpr const char* kProbeType = "tonus::bus_test::v1::Probe";

inline TopicSpec topic(const char* name, const Qos& qos, std::size_t max_payload_bytes = 65536) {
  return {name, kProbeType, qos, max_payload_bytes};
}

inline Qos keep_all(int depth, Durability durability = Durability::kVolatile) {
  return {.durability = durability, .history = History::kKeepAll, .depth = depth};
}

inline Qos state() {
  return {.durability = Durability::kTransientLocal, .history = History::kKeepLast, .depth = 1};
}

/// A state whose writer has to show life.
inline Qos watched_state() {
  Qos qos = state();
  qos.liveliness_lease = std::chrono::milliseconds{400};
  return qos;
}

inline Key key_of(std::uint8_t number) {
  Key key{};
  key.fill(0xa5);
  key[15] = number;
  return key;
}

/// Header, key, the number, and zeros up to `bytes`.
inline Payload payload(std::uint8_t key, std::uint64_t number, std::size_t bytes = 64) {
  Payload out(bytes, std::byte{0});
  out[1] = std::byte{1};
  const Key id = key_of(key);
  std::memcpy(out.data() + 4, id.data(), id.size());
  std::memcpy(out.data() + 20, &number, sizeof number);
  return out;
}

inline std::uint64_t number_in(const Payload& bytes) {
  std::uint64_t number = 0;
  std::memcpy(&number, bytes.data() + 20, sizeof number);
  return number;
}

}  // namespace tonus::bus::test
