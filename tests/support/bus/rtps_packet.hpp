#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace tonus::test {

/// Writes RTPS packets byte by byte (RTPS 2.3, 9.4), good ones and others. Little endian unless it is told
/// otherwise.
class RtpsPacket {
 public:
  using Bytes = std::vector<std::byte>;
  using Fill = std::function<void(RtpsPacket&)>;

  /// Begins with the header of a participant of eProsima's vendor id.
  explicit RtpsPacket(bool is_little_endian = true);

  RtpsPacket& u8(std::uint8_t value);
  RtpsPacket& u16(std::uint16_t value) { return number(value, 2); }
  RtpsPacket& u32(std::uint32_t value) { return number(value, 4); }
  RtpsPacket& sequence_number(std::int64_t value);
  RtpsPacket& entity(std::uint32_t id);
  RtpsPacket& zeros(std::size_t count);
  /// Length with the zero, characters, the zero, padding to 4 from where the packet's body is aligned.
  RtpsPacket& string(const std::string& text);

  /// One submessage; its byte-order flag and its length are set. `flags` without the byte order.
  RtpsPacket& submessage(std::uint8_t id, std::uint8_t flags, const Fill& fill);
  RtpsPacket& parameter(std::uint16_t id, const Fill& fill);
  RtpsPacket& sentinel() { return u16(1).u16(0); }

  /// Data of `writer` for everybody, with a payload (flag 4) or without (0), and inline QoS (flag 2).
  RtpsPacket& data(std::uint32_t writer, std::uint8_t flags, const Fill& rest);
  /// Discovery data: encapsulation of a parameter list, parameters, sentinel.
  RtpsPacket& discovery(std::uint32_t writer, const Fill& parameters);

  [[nodiscard]] Bytes& bytes() { return bytes_; }
  [[nodiscard]] const Bytes& bytes() const { return bytes_; }

 private:
  RtpsPacket& number(std::uint64_t value, std::size_t size);
  void set_length(std::size_t at, std::size_t length);

  bool is_little_endian_;
  Bytes bytes_;
};

inline constexpr std::uint32_t kParticipantWriter = 0x000100c2;
inline constexpr std::uint32_t kPublicationsWriter = 0x000003c2;
inline constexpr std::uint32_t kSubscriptionsWriter = 0x000004c2;
inline constexpr std::uint32_t kUserWriter = 0x00000102;

/// One good packet of every submessage that RTPS defines, and of every message of discovery, by name.
[[nodiscard]] std::vector<std::pair<std::string, RtpsPacket>> good_rtps_packets(bool is_little_endian);

/// 92 bytes: a good submessage, then statistics that are not the last thing in the packet. Fast DDS 2.9.1
/// ends its process by an assertion.
[[nodiscard]] RtpsPacket statistics_amid_packet();

}  // namespace tonus::test
