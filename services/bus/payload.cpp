#include "services/bus/payload.hpp"

#include <algorithm>
#include <cstring>
#include <string>

namespace tonus::bus {
namespace {

bool is_encapsulation_good(std::span<const std::byte> payload) {
  return payload[0] == std::byte{0} && payload[1] == std::byte{1};  // CDR_LE; the options after it are free
}

}  // namespace

bool is_payload_good(std::span<const std::byte> payload, std::size_t max_bytes) {
  return payload.size() >= kMinimumPayloadBytes && payload.size() <= padded_to_four(max_bytes) &&
         is_encapsulation_good(payload);
}

Result<void> check_payload(std::span<const std::byte> payload, std::size_t max_bytes) {
  if (payload.size() < kMinimumPayloadBytes) {
    return fail(ErrorCode::kInvalidArgument, "payload of " + std::to_string(payload.size()) +
                                                 " bytes: header and key need at least " +
                                                 std::to_string(kMinimumPayloadBytes));
  }
  if (payload.size() > padded_to_four(max_bytes)) {
    return fail(ErrorCode::kInvalidArgument, "payload of " + std::to_string(payload.size()) +
                                                 " bytes: the topic allows at most " +
                                                 std::to_string(max_bytes));
  }
  if (!is_encapsulation_good(payload)) {
    return fail(ErrorCode::kInvalidArgument, "payload with encapsulation " +
                                                 std::to_string(std::to_integer<int>(payload[0])) + " " +
                                                 std::to_string(std::to_integer<int>(payload[1])) +
                                                 ": only 0 1 (CDR, little endian) is allowed");
  }
  return {};
}

Payload greeting_payload() {
  Payload greeting(kMinimumPayloadBytes, std::byte{0xff});
  greeting[0] = std::byte{0x00};
  greeting[1] = std::byte{0x01};
  greeting[2] = greeting[3] = std::byte{0x00};
  return greeting;
}

bool is_greeting(std::span<const std::byte> payload) {
  return payload.size() == kMinimumPayloadBytes &&
         std::all_of(payload.begin() + kEncapsulationBytes, payload.end(),
                     [](std::byte byte) { return byte == std::byte{0xff}; });
}

Key payload_key(std::span<const std::byte> payload) {
  Key key{};
  if (payload.size() >= kMinimumPayloadBytes) {
    std::memcpy(key.data(), payload.data() + kEncapsulationBytes, key.size());
  }
  return key;
}

Payload padded_copy(std::span<const std::byte> payload) {
  Payload copy(padded_to_four(payload.size()), std::byte{0});
  std::copy(payload.begin(), payload.end(), copy.begin());
  return copy;
}

}  // namespace tonus::bus
