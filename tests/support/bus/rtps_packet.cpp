#include "tests/support/bus/rtps_packet.hpp"

namespace tonus::test {
namespace {

constexpr std::uint8_t kInlineQos = 2;
constexpr std::uint8_t kPayload = 4;
constexpr std::uint8_t kKeyOnly = 8;

void fill_entities(RtpsPacket& packet) { packet.entity(0).entity(kUserWriter); }

void fill_set(RtpsPacket& packet) { packet.u32(33).u32(0x80000000U).u32(0x80000000U); }

void fill_participant(RtpsPacket& packet) {
  packet.parameter(0x0015, [](RtpsPacket& p) { p.u8(2).u8(2).u16(0); })
      .parameter(0x0016, [](RtpsPacket& p) { p.u8(1).u8(15).u16(0); })
      .parameter(0x0050, [](RtpsPacket& p) { p.zeros(12).entity(0x000001c1); })
      .parameter(0x0031, [](RtpsPacket& p) { p.u32(1).u32(7411).zeros(12).u32(0x0100007fU); })
      .parameter(0x0002, [](RtpsPacket& p) { p.u32(3).u32(0); })
      .parameter(0x0058, [](RtpsPacket& p) { p.u32(0x3f); })
      .parameter(0x0062, [](RtpsPacket& p) { p.string("rig"); })
      .parameter(0x0059, [](RtpsPacket& p) { p.u32(1).string("key").string("a value"); });
}

void fill_endpoint(RtpsPacket& packet) {
  packet.parameter(0x0005, [](RtpsPacket& p) { p.string("rig/state"); })
      .parameter(0x0007, [](RtpsPacket& p) { p.string("tonus::v1::RigState"); })
      .parameter(0x005a, [](RtpsPacket& p) { p.zeros(12).entity(kUserWriter); })
      .parameter(0x001a, [](RtpsPacket& p) { p.u32(2).u32(0).u32(0); })
      .parameter(0x0029, [](RtpsPacket& p) { p.u32(2).string("left").string("right"); })
      .parameter(0x002c, [](RtpsPacket& p) { p.u32(3).u8(1).u8(2).u8(3).u8(0); })
      .parameter(0x0073, [](RtpsPacket& p) { p.u32(1).u16(0).u16(0); })
      .parameter(0x8007, [](RtpsPacket& p) { p.u32(0); });  // of another vendor
}

void fill_fragment(RtpsPacket& packet) {
  packet.u16(0).u16(28).entity(0).entity(kUserWriter).sequence_number(1);
  packet.u32(2).u16(1).u16(128).u32(300).zeros(128);
}

RtpsPacket with(bool is_little_endian, const RtpsPacket::Fill& fill) {
  RtpsPacket packet(is_little_endian);
  fill(packet);
  return packet;
}

}  // namespace

RtpsPacket::RtpsPacket(bool is_little_endian) : is_little_endian_(is_little_endian) {
  for (const char c : {'R', 'T', 'P', 'S'}) u8(static_cast<std::uint8_t>(c));
  u8(2).u8(2).u8(1).u8(15).zeros(11).u8(77);
}

RtpsPacket& RtpsPacket::u8(std::uint8_t value) {
  bytes_.push_back(static_cast<std::byte>(value));
  return *this;
}

RtpsPacket& RtpsPacket::number(std::uint64_t value, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t place = is_little_endian_ ? i : size - 1 - i;
    u8(static_cast<std::uint8_t>(value >> (8 * place)));
  }
  return *this;
}

RtpsPacket& RtpsPacket::sequence_number(std::int64_t value) {
  const auto bits = static_cast<std::uint64_t>(value);
  return u32(static_cast<std::uint32_t>(bits >> 32U)).u32(static_cast<std::uint32_t>(bits));
}

RtpsPacket& RtpsPacket::entity(std::uint32_t id) {
  for (unsigned shift = 32; shift > 0; shift -= 8) u8(static_cast<std::uint8_t>(id >> (shift - 8)));
  return *this;
}

RtpsPacket& RtpsPacket::zeros(std::size_t count) {
  bytes_.resize(bytes_.size() + count);
  return *this;
}

RtpsPacket& RtpsPacket::string(const std::string& text) {
  u32(static_cast<std::uint32_t>(text.size() + 1));
  for (const char c : text) u8(static_cast<std::uint8_t>(c));
  u8(0);
  return zeros((4 - bytes_.size() % 4) % 4);
}

RtpsPacket& RtpsPacket::submessage(std::uint8_t id, std::uint8_t flags, const Fill& fill) {
  u8(id).u8(static_cast<std::uint8_t>(flags | (is_little_endian_ ? 1U : 0U))).u16(0);
  const std::size_t begin = bytes_.size();
  fill(*this);
  set_length(begin - 2, bytes_.size() - begin);
  return *this;
}

RtpsPacket& RtpsPacket::parameter(std::uint16_t id, const Fill& fill) {
  u16(id).u16(0);
  const std::size_t begin = bytes_.size();
  fill(*this);
  set_length(begin - 2, bytes_.size() - begin);
  return *this;
}

void RtpsPacket::set_length(std::size_t at, std::size_t length) {
  Bytes rest(bytes_.begin() + static_cast<std::ptrdiff_t>(at + 2), bytes_.end());
  bytes_.resize(at);
  u16(static_cast<std::uint16_t>(length));
  bytes_.insert(bytes_.end(), rest.begin(), rest.end());
}

RtpsPacket& RtpsPacket::data(std::uint32_t writer, std::uint8_t flags, const Fill& rest) {
  return submessage(0x15, flags, [&](RtpsPacket& packet) {
    packet.u16(0).u16(16).entity(0).entity(writer).sequence_number(1);
    rest(packet);
  });
}

RtpsPacket& RtpsPacket::discovery(std::uint32_t writer, const Fill& parameters) {
  return data(writer, kPayload, [&](RtpsPacket& packet) {
    packet.u8(0).u8(is_little_endian_ ? 3 : 2).u8(0).u8(0);
    parameters(packet);
    packet.sentinel();
  });
}

std::vector<std::pair<std::string, RtpsPacket>> good_rtps_packets(bool is_little_endian) {
  const auto one = [&](std::uint8_t id, std::uint8_t flags, const RtpsPacket::Fill& fill) {
    return with(is_little_endian, [&](RtpsPacket& packet) { packet.submessage(id, flags, fill); });
  };
  const auto data = [&](std::uint32_t writer, std::uint8_t flags, const RtpsPacket::Fill& fill) {
    return with(is_little_endian, [&](RtpsPacket& packet) { packet.data(writer, flags, fill); });
  };
  const auto discovery = [&](std::uint32_t writer, const RtpsPacket::Fill& fill) {
    return with(is_little_endian, [&](RtpsPacket& packet) { packet.discovery(writer, fill); });
  };
  return {
      {"Padding", one(0x01, 0, [](RtpsPacket& p) { p.zeros(8); })},
      {"AckNack", one(0x06, 2,
                      [](RtpsPacket& p) {
                        fill_entities(p);
                        fill_set(p.sequence_number(5));
                        p.u32(1);
                      })},
      {"Heartbeat", one(0x07, 0,
                        [](RtpsPacket& p) {
                          fill_entities(p);
                          p.sequence_number(1).sequence_number(9).u32(1);
                        })},
      {"Gap", one(0x08, 0,
                  [](RtpsPacket& p) {
                    fill_entities(p);
                    fill_set(p.sequence_number(3).sequence_number(9));
                  })},
      {"Timestamp", one(0x09, 0, [](RtpsPacket& p) { p.u32(1).u32(2); })},
      {"TimestampInvalid", one(0x09, 2, [](RtpsPacket&) {})},
      {"Source", one(0x0c, 0, [](RtpsPacket& p) { p.u32(0).u8(2).u8(2).u8(1).u8(15).zeros(12); })},
      {"ReplyIp4", one(0x0d, 2, [](RtpsPacket& p) { p.zeros(16); })},
      {"Destination", one(0x0e, 0, [](RtpsPacket& p) { p.zeros(12); })},
      {"Reply", one(0x0f, 2, [](RtpsPacket& p) { p.u32(1).zeros(24).u32(2).zeros(48); })},
      {"NackFragment", one(0x12, 0,
                           [](RtpsPacket& p) {
                             fill_entities(p);
                             fill_set(p.sequence_number(5).u32(1));
                             p.u32(1);
                           })},
      {"HeartbeatFragment", one(0x13, 0,
                                [](RtpsPacket& p) {
                                  fill_entities(p);
                                  p.sequence_number(5).u32(3).u32(1);
                                })},
      {"Data", data(kUserWriter, kPayload, [](RtpsPacket& p) { p.u8(0).u8(1).u8(0).u8(0).zeros(60); })},
      {"DataWithInlineQos", data(kUserWriter, kPayload | kInlineQos,
                                 [](RtpsPacket& p) {
                                   p.parameter(0x0070, [](RtpsPacket& q) { q.zeros(16); })
                                       .parameter(0x800f, [](RtpsPacket& q) { q.zeros(24); })
                                       .sentinel()
                                       .zeros(24);
                                 })},
      {"DataOfAKeyThatIsDisposed", data(kUserWriter, kKeyOnly | kInlineQos,
                                        [](RtpsPacket& p) {
                                          p.parameter(0x0071, [](RtpsPacket& q) { q.u32(1); }).sentinel();
                                          p.zeros(20);
                                        })},
      {"DataWithoutPayload", data(kUserWriter, 0, [](RtpsPacket&) {})},
      {"DataFragment", one(0x16, 0, fill_fragment)},
      {"Participant", discovery(kParticipantWriter, fill_participant)},
      {"Publication", discovery(kPublicationsWriter, fill_endpoint)},
      {"Subscription", discovery(kSubscriptionsWriter, fill_endpoint)},
      {"Liveliness", data(0x000200c2, kPayload, [](RtpsPacket& p) { p.u8(0).u8(1).zeros(30); })},
  };
}

RtpsPacket statistics_amid_packet() {
  RtpsPacket packet;
  return packet.submessage(0x80, 0, [](RtpsPacket& p) { p.zeros(56); })
      .submessage(0x09, 0, [](RtpsPacket& p) { p.zeros(8); });
}

}  // namespace tonus::test
