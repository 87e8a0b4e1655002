#include "services/bus/fastdds/rtps_check.hpp"

#include <algorithm>
#include <array>

namespace tonus::bus {
namespace {

constexpr std::size_t kHeaderBytes = 20;
constexpr std::size_t kPrefixAt = 8;  // of the sending participant
constexpr std::size_t kPrefixBytes = 12;
constexpr std::size_t kSubmessageHeaderBytes = 4;
constexpr std::array kMagic{std::byte{'R'}, std::byte{'T'}, std::byte{'P'}, std::byte{'S'}};
constexpr std::byte kMajorVersion{2};

/// Fast DDS goes through a gap number by number, and remembers each. A history holds far fewer.
constexpr std::int64_t kLongestGap = 1 << 18;
constexpr std::uint32_t kMostBits = 256;      // of a set of numbers, RTPS 2.3, 9.4.2.6
constexpr std::uint32_t kMostLocators = 64;   // of a reply's list
constexpr std::uint16_t kLeastFragment = 64;  // bytes; Fast DDS keeps links inside of missing fragments

enum Id : std::uint8_t {
  kPad = 0x01,
  kAckNack = 0x06,
  kHeartbeat = 0x07,
  kGap = 0x08,
  kInfoTimestamp = 0x09,
  kInfoSource = 0x0c,
  kInfoReplyIp4 = 0x0d,
  kInfoDestination = 0x0e,
  kInfoReply = 0x0f,
  kNackFragment = 0x12,
  kHeartbeatFragment = 0x13,
  kData = 0x15,
  kDataFragment = 0x16,
  kSecureBody = 0x30,
  kSecurePrefix = 0x31,
  kSecurePostfix = 0x32,
  kSecureRtpsPrefix = 0x33,
  kSecureRtpsPostfix = 0x34,
  kFastStatistics = 0x80,
};

/// Built-in writers and readers whose messages are parameter lists: participants, writers and readers, in
/// clear and protected.
constexpr std::array<std::uint32_t, 12> kDiscovery{0x000100c2, 0x000100c7, 0x000003c2, 0x000003c7,
                                                   0x000004c2, 0x000004c7, 0xff0101c2, 0xff0101c7,
                                                   0xff0003c2, 0xff0003c7, 0xff0004c2, 0xff0004c7};

/// Built-in writer and reader of liveliness, in clear and protected: who, what kind, and a sequence of bytes.
constexpr std::array<std::uint32_t, 4> kLiveliness{0x000200c2, 0x000200c7, 0xff0200c2, 0xff0200c7};
constexpr std::size_t kLivelinessBytes = 24;

struct Submessage {
  std::uint8_t id = 0;
  std::uint8_t flags = 0;
  std::span<const std::byte> body;
  std::size_t at = 0;  // of the body in the datagram

  [[nodiscard]] bool has(unsigned bit) const { return (flags >> bit & 1U) != 0; }
  [[nodiscard]] ByteCursor cursor() const { return {body, has(0)}; }
};

RtpsFault contents_if(bool is_good) { return is_good ? RtpsFault::kNone : RtpsFault::kContents; }

/// The bits of a set of numbers, behind its first number.
bool skip_bits(ByteCursor& cursor) {
  const std::uint32_t bits = cursor.u32();
  if (bits > kMostBits) return false;
  cursor.skip(std::size_t{4} * ((bits + 31) / 32));
  return !cursor.has_failed();
}

/// An array of bytes, so of no byte order.
std::uint32_t read_entity(ByteCursor& cursor) {
  std::uint32_t entity = 0;
  for (int i = 0; i < 4; ++i) entity = entity << 8U | cursor.u8();
  return entity;
}

/// Reader and writer.
ByteCursor behind_entities(const Submessage& submessage) {
  ByteCursor cursor = submessage.cursor();
  cursor.skip(8);
  return cursor;
}

RtpsFault check_acknack(const Submessage& submessage, std::span<const std::byte> datagram,
                        RtpsChecked& checked) {
  ByteCursor cursor = behind_entities(submessage);
  Acknowledgement word;
  word.at = submessage.at - kSubmessageHeaderBytes;
  word.is_little_endian = submessage.has(0);
  word.base = cursor.sequence_number();  // 0: the first word of a reader
  const std::size_t set_at = cursor.position();
  const bool is_good = word.base >= 0 && skip_bits(cursor);
  word.asks = cursor.position() > set_at + 4;  // behind the count of bits there are some
  word.count_at = submessage.at + cursor.position();
  word.count = cursor.u32();
  if (!is_good || cursor.has_failed()) return RtpsFault::kContents;
  const auto prefix = datagram.subspan(kPrefixAt, kPrefixBytes);
  const auto rest = std::copy(prefix.begin(), prefix.end(), word.ends.begin());
  std::copy_n(submessage.body.begin(), word.ends.size() - kPrefixBytes, rest);
  checked.acknowledgements.push_back(word);
  return RtpsFault::kNone;
}

RtpsFault check_heartbeat(const Submessage& submessage) {
  ByteCursor cursor = behind_entities(submessage);
  const std::int64_t first = cursor.sequence_number();
  const std::int64_t last = cursor.sequence_number();
  cursor.skip(4);
  return contents_if(!cursor.has_failed() && first >= 0 && last >= first - 1);
}

RtpsFault check_gap(const Submessage& submessage) {
  ByteCursor cursor = behind_entities(submessage);
  const std::int64_t start = cursor.sequence_number();
  const std::int64_t base = cursor.sequence_number();
  const bool is_good = start >= 1 && base >= start && base - start <= kLongestGap && skip_bits(cursor);
  return contents_if(is_good);
}

RtpsFault check_nack_fragment(const Submessage& submessage) {
  ByteCursor cursor = behind_entities(submessage);
  const std::int64_t number = cursor.sequence_number();
  cursor.skip(4);
  const bool is_good = number >= 1 && skip_bits(cursor);
  cursor.skip(4);
  return contents_if(is_good && !cursor.has_failed());
}

RtpsFault check_heartbeat_fragment(const Submessage& submessage) {
  ByteCursor cursor = behind_entities(submessage);
  const std::int64_t number = cursor.sequence_number();
  cursor.skip(8);
  return contents_if(number >= 1 && !cursor.has_failed());
}

RtpsFault check_timestamp(const Submessage& submessage) {
  const bool is_invalidated = submessage.has(1);
  return contents_if(is_invalidated || submessage.body.size() >= 8);
}

RtpsFault check_reply(const Submessage& submessage, std::size_t locator_bytes) {
  ByteCursor cursor = submessage.cursor();
  const bool has_multicast = submessage.has(1);
  if (submessage.id == kInfoReplyIp4) {
    cursor.skip(has_multicast ? 2 * locator_bytes : locator_bytes);
    return contents_if(!cursor.has_failed());
  }
  for (int list = 0; list < (has_multicast ? 2 : 1); ++list) {
    const std::uint32_t count = cursor.u32();
    if (count > kMostLocators) return RtpsFault::kContents;
    cursor.skip(count * locator_bytes);
  }
  return contents_if(!cursor.has_failed());
}

/// Skips what lies between what has been `read` behind the length `to_inline_qos`, and the payload.
RtpsFault skip_to_payload(ByteCursor& cursor, const Submessage& submessage, std::uint16_t to_inline_qos,
                          std::uint16_t read) {
  if (cursor.has_failed() || to_inline_qos < read || to_inline_qos % 4 != 0) return RtpsFault::kContents;
  cursor.skip(to_inline_qos - read);
  if (cursor.has_failed()) return RtpsFault::kContents;
  const bool has_inline_qos = submessage.has(1);
  if (has_inline_qos && !is_inline_qos(cursor)) return RtpsFault::kParameters;
  return RtpsFault::kNone;
}

struct Address {
  std::uint16_t to_inline_qos = 0;
  std::uint32_t reader = 0;
  std::uint32_t writer = 0;
  std::int64_t number = 0;

  template <std::size_t N>
  [[nodiscard]] bool is_of(const std::array<std::uint32_t, N>& entities) const {
    return std::ranges::find(entities, reader) != entities.end() ||
           std::ranges::find(entities, writer) != entities.end();
  }
};

/// What data and fragments begin with.
Address read_address(ByteCursor& cursor) {
  Address address;
  cursor.skip(2);
  address.to_inline_qos = cursor.u16();
  address.reader = read_entity(cursor);
  address.writer = read_entity(cursor);
  address.number = cursor.sequence_number();
  return address;
}

RtpsFault check_data(const Submessage& submessage, std::vector<BytePatch>& patches) {
  const bool has_data = submessage.has(2);
  const bool has_key = submessage.has(3);
  if (has_data && has_key) return RtpsFault::kFlags;
  ByteCursor cursor = submessage.cursor();
  const Address address = read_address(cursor);
  if (cursor.has_failed() || address.number < 1) return RtpsFault::kContents;
  constexpr std::uint16_t kFixed = 16;  // reader, writer, number
  if (const auto fault = skip_to_payload(cursor, submessage, address.to_inline_qos, kFixed);
      fault != RtpsFault::kNone) {
    return fault;
  }
  if (!has_data && !has_key) return RtpsFault::kNone;
  if (cursor.left() < 4) return RtpsFault::kContents;  // a payload begins with how it is encoded
  if (!has_data) return RtpsFault::kNone;
  if (address.is_of(kLiveliness)) return contents_if(cursor.left() >= kLivelinessBytes);
  if (!address.is_of(kDiscovery)) return RtpsFault::kNone;
  const std::size_t at = submessage.at + cursor.position();
  return is_discovery_payload(cursor.take(cursor.left()), at, patches) ? RtpsFault::kNone
                                                                       : RtpsFault::kParameters;
}

struct Fragments {
  std::uint32_t first = 0;  // from 1
  std::uint16_t count = 0;
  std::uint16_t size = 0;
  std::uint32_t sample_bytes = 0;
};

/// Within the sample, and with room for the links that Fast DDS keeps at the start of each missing fragment.
bool are_within(const Fragments& fragments, std::size_t payload_bytes, const RtpsLimits& limits) {
  if (fragments.first < 1 || fragments.count < 1 || fragments.size < kLeastFragment) return false;
  if (fragments.sample_bytes < 1 || fragments.sample_bytes > limits.message_bytes) return false;
  const std::uint64_t size = fragments.size;
  const std::uint64_t all = (fragments.sample_bytes + size - 1) / size;
  const std::uint64_t end = std::uint64_t{fragments.first} - 1 + fragments.count;
  const std::uint64_t last_link = ((all - 1) * size + 3) / 4 * 4;
  if (end > all || last_link + 4 > fragments.sample_bytes) return false;
  const std::uint64_t needed =
      std::min<std::uint64_t>(end * size, fragments.sample_bytes) - (fragments.first - 1) * size;
  return payload_bytes >= needed;
}

RtpsFault check_data_fragment(const Submessage& submessage, const RtpsLimits& limits) {
  ByteCursor cursor = submessage.cursor();
  const Address address = read_address(cursor);
  Fragments fragments;
  fragments.first = cursor.u32();
  fragments.count = cursor.u16();
  fragments.size = cursor.u16();
  fragments.sample_bytes = cursor.u32();
  if (cursor.has_failed() || address.number < 1) return RtpsFault::kContents;
  constexpr std::uint16_t kFixed = 28;  // reader, writer, number, what fragments they are
  if (const auto fault = skip_to_payload(cursor, submessage, address.to_inline_qos, kFixed);
      fault != RtpsFault::kNone) {
    return fault;
  }
  // Discovery that comes in pieces cannot be checked here, and never does so among peers of tonus.
  if (address.is_of(kDiscovery) || address.is_of(kLiveliness)) return RtpsFault::kContents;
  return contents_if(are_within(fragments, cursor.left(), limits));
}

RtpsFault check_submessage(const Submessage& submessage, std::span<const std::byte> datagram,
                           const RtpsLimits& limits, RtpsChecked& checked) {
  constexpr std::size_t kLocatorBytes = 24;
  constexpr std::size_t kIp4LocatorBytes = 8;
  switch (submessage.id) {
    case kAckNack:
      return check_acknack(submessage, datagram, checked);
    case kHeartbeat:
      return check_heartbeat(submessage);
    case kGap:
      return check_gap(submessage);
    case kInfoTimestamp:
      return check_timestamp(submessage);
    case kInfoSource:
      return contents_if(submessage.body.size() == 20);
    case kInfoDestination:
      return contents_if(submessage.body.size() >= 12);
    case kInfoReply:
      return check_reply(submessage, kLocatorBytes);
    case kInfoReplyIp4:
      return check_reply(submessage, kIp4LocatorBytes);
    case kNackFragment:
      return check_nack_fragment(submessage);
    case kHeartbeatFragment:
      return check_heartbeat_fragment(submessage);
    case kData:
      return check_data(submessage, checked.patches);
    case kDataFragment:
      return check_data_fragment(submessage, limits);
    case kPad:
    case kSecureBody:
    case kSecurePrefix:
    case kSecurePostfix:
    case kSecureRtpsPrefix:
    case kSecureRtpsPostfix:
      return RtpsFault::kNone;  // skipped, or authenticated before anything else is read
    default:
      return RtpsFault::kSubmessage;
  }
}

/// One that says 0 reaches to the end, but for the two that may be empty.
std::size_t length_of(std::uint8_t id, std::uint16_t stated, std::size_t left) {
  return stated == 0 && id != kPad && id != kInfoTimestamp ? left : stated;
}

RtpsFault check_header(std::span<const std::byte> datagram) {
  if (datagram.size() < kHeaderBytes) return RtpsFault::kHeader;
  if (!std::equal(kMagic.begin(), kMagic.end(), datagram.begin())) return RtpsFault::kHeader;
  return datagram[4] == kMajorVersion ? RtpsFault::kNone : RtpsFault::kVersion;
}

RtpsChecked refused(RtpsFault fault) { return {fault, {}, {}, {}}; }

}  // namespace

std::string_view text_of(RtpsFault fault) {
  switch (fault) {
    case RtpsFault::kNone:
      return "good";
    case RtpsFault::kHeader:
      return "not RTPS";
    case RtpsFault::kVersion:
      return "protocol version is not 2";
    case RtpsFault::kSubmessage:
      return "unknown submessage";
    case RtpsFault::kLength:
      return "a submessage's length leads out of the packet";
    case RtpsFault::kFlags:
      return "flags contradict each other";
    case RtpsFault::kContents:
      return "contents of a submessage are out of bounds";
    case RtpsFault::kParameters:
      return "a parameter list is broken";
  }
  return "unknown fault";
}

RtpsChecked check_rtps(std::span<const std::byte> datagram, const RtpsLimits& limits) {
  if (const auto fault = check_header(datagram); fault != RtpsFault::kNone) return refused(fault);
  RtpsChecked checked{RtpsFault::kNone, datagram, {}, {}};
  for (std::size_t at = kHeaderBytes; at < datagram.size();) {
    if (datagram.size() - at < kSubmessageHeaderBytes) return refused(RtpsFault::kLength);
    Submessage submessage;
    submessage.id = static_cast<std::uint8_t>(datagram[at]);
    submessage.flags = static_cast<std::uint8_t>(datagram[at + 1]);
    const std::size_t begin = at + kSubmessageHeaderBytes;
    ByteCursor header(datagram.subspan(at + 2, 2), submessage.has(0));
    const std::size_t length = length_of(submessage.id, header.u16(), datagram.size() - begin);
    const std::size_t end = begin + length;
    if (end > datagram.size()) return refused(RtpsFault::kLength);
    const bool is_last = end == datagram.size();
    if (!is_last && length % 4 != 0) return refused(RtpsFault::kLength);
    if (submessage.id == kFastStatistics && is_last) {
      checked.message = datagram.first(at);
      break;
    }
    submessage.body = datagram.subspan(begin, length);
    submessage.at = begin;
    if (const auto fault = check_submessage(submessage, datagram, limits, checked); fault != RtpsFault::kNone)
      return refused(fault);
    at = end;
  }
  return checked;
}

}  // namespace tonus::bus
