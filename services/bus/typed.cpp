#include "services/bus/typed.hpp"

#include <exception>
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastcdr/exceptions/Exception.h>

#include "services/bus/payload.hpp"

namespace tonus::bus::detail {
namespace {

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

/// Calls `action` and turns whatever it throws into one line.
template <typename Action>
Result<void> without_exceptions(const std::string& what, const Action& action) {
  try {
    action();
    return {};
  } catch (const eprosima::fastcdr::exception::Exception& error) {
    return fail(ErrorCode::kInvalidArgument, what + ": " + error.what());
  } catch (const std::exception& error) {
    return fail(ErrorCode::kInvalidArgument, what + ": " + error.what());
  } catch (...) {
    return fail(ErrorCode::kInvalidArgument, what + ": not a value of its type");
  }
}

}  // namespace

Result<Payload> encode_members(std::size_t member_bytes, const void* value,
                               void (*serialize)(const void*, Cdr&)) {
  const std::size_t payload_bytes = kEncapsulationBytes + member_bytes;
  Payload payload(padded_to_four(payload_bytes), std::byte{0});
  std::size_t written = 0;
  auto done = without_exceptions("message of " + std::to_string(payload_bytes) + " bytes", [&] {
    FastBuffer buffer(reinterpret_cast<char*>(payload.data()), payload.size());
    Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
    cdr.serialize_encapsulation();
    serialize(value, cdr);
    written = cdr.getSerializedDataLength();
  });
  if (!done) return done.error();
  if (written != payload_bytes) {
    return fail(ErrorCode::kInvalidArgument, "message takes " + std::to_string(written) +
                                                 " bytes instead of " + std::to_string(payload_bytes) +
                                                 ": a string must not hold a zero byte");
  }
  return payload;
}

Result<std::size_t> decode_members(std::span<const std::byte> payload, void* value,
                                   void (*deserialize)(void*, Cdr&)) {
  if (auto good = check_payload(payload, payload.size()); !good) return good.error();
  std::size_t read = 0;
  auto done = without_exceptions("payload of " + std::to_string(payload.size()) + " bytes", [&] {
    // FastBuffer has no const form; reading does not change the bytes.
    auto* bytes = const_cast<char*>(reinterpret_cast<const char*>(payload.data()));
    FastBuffer buffer(bytes, payload.size());
    Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
    cdr.read_encapsulation();
    deserialize(value, cdr);
    read = cdr.getSerializedDataLength();
  });
  if (!done) return done.error();
  return read;
}

Result<void> check_extent(std::size_t payload_bytes, std::size_t read_bytes, std::size_t value_bytes) {
  if (read_bytes != kEncapsulationBytes + value_bytes) {
    return fail(ErrorCode::kInvalidArgument, "payload holds a value of " + std::to_string(value_bytes) +
                                                 " bytes in " +
                                                 std::to_string(read_bytes - kEncapsulationBytes) +
                                                 ": a string is over its bound or ill-formed");
  }
  if (payload_bytes - read_bytes > 3) {
    return fail(ErrorCode::kInvalidArgument, "payload of " + std::to_string(payload_bytes) +
                                                 " bytes: its value ends at " + std::to_string(read_bytes) +
                                                 ", at most 3 bytes of padding may follow");
  }
  return {};
}

}  // namespace tonus::bus::detail
