#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "services/bus/fastdds/parameter_check.hpp"

namespace tonus::bus {

/// What is wrong with a received datagram.
enum class RtpsFault : std::uint8_t {
  kNone,
  kHeader,      ///< Shorter than a header, or not "RTPS".
  kVersion,     ///< Not of protocol version 2.
  kSubmessage,  ///< An id that RTPS does not define, or that only a vendor knows.
  kLength,      ///< A submessage that does not end within the datagram, or not at a multiple of 4.
  kFlags,       ///< Flags that contradict each other.
  kContents,    ///< Lengths, counts or numbers inside a submessage that lead out of it or out of all bounds.
  kParameters,  ///< A parameter list that does not end, or a parameter whose contents do not fit its length.
};

[[nodiscard]] std::string_view text_of(RtpsFault fault);

/// What a participant takes.
struct RtpsLimits {
  std::size_t message_bytes = 65536;  ///< Largest sample that may come in fragments, with its header.
};

/// A remote reader's word to a writer on what it has.
struct Acknowledgement {
  std::size_t at = 0;                ///< Of the submessage in the datagram.
  std::size_t count_at = 0;          ///< Of the acknowledgement's count.
  std::array<std::byte, 20> ends{};  ///< Participant and entity of the reader, entity of the writer.
  std::int64_t base = 0;             ///< The first number that the reader lacks.
  bool asks = false;                 ///< It wants what it lacks.
  bool is_little_endian = true;      ///< As the submessage is encoded.
  std::uint32_t count = 0;           ///< The reader's own; Fast DDS takes no word whose count is not higher.
};

struct RtpsChecked {
  RtpsFault fault = RtpsFault::kNone;
  /// What may be parsed: the datagram without the statistics that Fast DDS appends. Empty if there is a
  /// fault.
  std::span<const std::byte> message;
  std::vector<BytePatch> patches;  ///< To be made first; hardly ever any.
  std::vector<Acknowledgement> acknowledgements{};
};

/// Checks one datagram before Fast DDS 2.9.1 parses it, since that parser ends its process on some datagrams
/// (assertions, an allocation of any size) and counts through others for hours. Covers headers and
/// submessages (RTPS 2.3, 8.3 and 9.4) and the discovery data that every participant sends (9.6.2); what
/// applications send inside is checked where it is decoded. From any thread.
[[nodiscard]] RtpsChecked check_rtps(std::span<const std::byte> datagram, const RtpsLimits& limits = {});

}  // namespace tonus::bus
