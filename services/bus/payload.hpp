#pragma once

#include <cstddef>
#include <span>

#include "services/bus/bus.hpp"

/// What every carrier knows of a payload: header, key, length. See bus.hpp for the layout.
namespace tonus::bus {

inline constexpr std::size_t kEncapsulationBytes = 4;
inline constexpr std::size_t kMinimumPayloadBytes = kEncapsulationBytes + 16;

/// kInvalidArgument when the payload is shorter than header and key, longer than `max_bytes`, or not XCDR1
/// little endian. Says nothing about the members after the key.
[[nodiscard]] Result<void> check_payload(std::span<const std::byte> payload, std::size_t max_bytes);

/// As check_payload, without a message.
[[nodiscard]] bool is_payload_good(std::span<const std::byte> payload, std::size_t max_bytes);

/// Bytes 4 to 19; all zeros where the payload is too short to have a key.
[[nodiscard]] Key payload_key(std::span<const std::byte> payload);

/// A message to nobody: header and a key of ones, no members. A Fast DDS writer sends it to learn that a
/// reader of another implementation hears it (fast_writer.cpp); readers of this bus pass it over without a
/// word, others refuse it as too short for their type.
[[nodiscard]] Payload greeting_payload();
[[nodiscard]] bool is_greeting(std::span<const std::byte> payload);

[[nodiscard]] constexpr std::size_t padded_to_four(std::size_t bytes) {
  return (bytes + 3) & ~std::size_t{3};
}

/// A copy with zeros to a multiple of four, which is what RTPS puts on the wire.
[[nodiscard]] Payload padded_copy(std::span<const std::byte> payload);

}  // namespace tonus::bus
