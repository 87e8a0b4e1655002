#include "services/bus/fastdds/parameter_check.hpp"

#include <algorithm>
#include <array>

namespace tonus::bus {
namespace {

constexpr std::uint16_t kSentinel = 0x0001;
constexpr std::size_t kLongestString = 256;  // Fast DDS keeps 255 characters and the zero
constexpr std::uint32_t kMostItems = 100;

/// How the value of a parameter is built.
enum class Form : std::uint8_t {
  kFixed,       ///< Exactly `size` bytes.
  kString,      ///< Length with the final zero, characters.
  kBytes,       ///< Length, bytes.
  kNumbers,     ///< Count, numbers of `size` bytes.
  kStrings,     ///< Count, strings.
  kProperties,  ///< Count, pairs of strings.
  kToken,       ///< A string, properties, binary properties.
  kFilter,      ///< Four strings, then strings.
};

struct Rule {
  std::uint16_t id;
  Form form;
  std::uint16_t size = 0;
};

/// Every parameter that Fast DDS 2.9.1 reads in discovery; it skips others by their length.
constexpr std::array kRules{
    Rule{0x0002, Form::kFixed, 8},    // participant lease
    Rule{0x0004, Form::kFixed, 8},    // time-based filter
    Rule{0x0005, Form::kString},      // topic name
    Rule{0x0006, Form::kFixed, 4},    // ownership strength
    Rule{0x0007, Form::kString},      // type name
    Rule{0x0015, Form::kFixed, 4},    // protocol version
    Rule{0x0016, Form::kFixed, 4},    // vendor
    Rule{0x001a, Form::kFixed, 12},   // reliability
    Rule{0x001b, Form::kFixed, 12},   // liveliness
    Rule{0x001d, Form::kFixed, 4},    // durability
    Rule{0x001e, Form::kFixed, 28},   // durability service
    Rule{0x001f, Form::kFixed, 4},    // ownership
    Rule{0x0021, Form::kFixed, 8},    // presentation
    Rule{0x0023, Form::kFixed, 8},    // deadline
    Rule{0x0025, Form::kFixed, 4},    // destination order
    Rule{0x0027, Form::kFixed, 8},    // latency budget
    Rule{0x0029, Form::kStrings},     // partition
    Rule{0x002b, Form::kFixed, 8},    // lifespan
    Rule{0x002c, Form::kBytes},       // user data
    Rule{0x002d, Form::kBytes},       // group data
    Rule{0x002e, Form::kBytes},       // topic data
    Rule{0x002f, Form::kFixed, 24},   // unicast locator
    Rule{0x0030, Form::kFixed, 24},   // multicast locator
    Rule{0x0031, Form::kFixed, 24},   // default unicast locator
    Rule{0x0032, Form::kFixed, 24},   // metatraffic unicast locator
    Rule{0x0033, Form::kFixed, 24},   // metatraffic multicast locator
    Rule{0x0035, Form::kFilter},      // content filter
    Rule{0x0040, Form::kFixed, 8},    // history
    Rule{0x0041, Form::kFixed, 12},   // resource limits
    Rule{0x0043, Form::kFixed, 4},    // expects inline QoS
    Rule{0x0048, Form::kFixed, 24},   // default multicast locator
    Rule{0x0049, Form::kFixed, 4},    // transport priority
    Rule{0x0050, Form::kFixed, 16},   // participant
    Rule{0x0052, Form::kFixed, 16},   // group
    Rule{0x0058, Form::kFixed, 4},    // built-in endpoints
    Rule{0x0059, Form::kProperties},  // properties
    Rule{0x005a, Form::kFixed, 16},   // endpoint
    Rule{0x0060, Form::kFixed, 4},    // largest serialised size
    Rule{0x0062, Form::kString},      // entity name
    Rule{0x0070, Form::kFixed, 16},   // key
    Rule{0x0071, Form::kFixed, 4},    // status
    Rule{0x0073, Form::kNumbers, 2},  // data representation
    Rule{0x1001, Form::kToken},       // identity
    Rule{0x1002, Form::kToken},       // permissions
    Rule{0x1004, Form::kFixed, 8},    // endpoint security
    Rule{0x1005, Form::kFixed, 8},    // participant security
    Rule{0x8002, Form::kFixed, 16},   // persistence
    Rule{0x8005, Form::kFixed, 4},    // no positive acknowledgements
};

/// What Fast DDS 2.9.1 hands to decoders that make room for any length and throw past its threads' ends, or
/// opens shared memory for. No type of tonus comes with it; a native peer of a type by its name works
/// without.
constexpr std::array<std::uint16_t, 4> kPadded{0x0069, 0x0072, 0x0075, 0x8006};

constexpr std::uint16_t kParticipantLease = 0x0002;
constexpr std::uint16_t kKeyHash = 0x0070;
constexpr std::uint16_t kStatusInfo = 0x0071;
constexpr std::size_t kEncapsulationBytes = 4;
constexpr std::size_t kParameterHeaderBytes = 4;

struct Parameter {
  std::size_t at = 0;  // of the id, from where the list begins
  std::uint16_t id = 0;
  std::span<const std::byte> value;
};

/// False where the list is broken; the sentinel is a parameter without value.
bool next_parameter(ByteCursor& cursor, Parameter& parameter) {
  parameter.at = cursor.position();
  parameter.id = cursor.u16();
  const std::uint16_t length = cursor.u16();
  parameter.value = {};
  if (cursor.has_failed()) return false;
  if (parameter.id == kSentinel) return true;
  parameter.value = cursor.take(length);
  return !cursor.has_failed() && length % 4 == 0;
}

/// A string that ends with a zero where it says; an empty one may have no zero.
bool skip_string(ByteCursor& cursor, std::size_t longest) {
  const std::uint32_t length = cursor.u32();
  if (length > longest) return false;
  const auto text = cursor.take(length);
  if (cursor.has_failed() || (length > 0 && text.back() != std::byte{0})) return false;
  cursor.align();
  return !cursor.has_failed();
}

bool skip_bytes(ByteCursor& cursor) {
  cursor.skip(cursor.u32());
  cursor.align();
  return !cursor.has_failed();
}

template <typename Skip>
bool skip_items(ByteCursor& cursor, const Skip& skip) {
  const std::uint32_t count = cursor.u32();
  if (cursor.has_failed() || count > kMostItems) return false;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (!skip(cursor)) return false;
  }
  return true;
}

bool skip_text(ByteCursor& cursor) { return skip_string(cursor, cursor.left()); }
bool skip_name(ByteCursor& cursor) { return skip_string(cursor, kLongestString); }
bool skip_property(ByteCursor& cursor) { return skip_text(cursor) && skip_text(cursor); }
bool skip_binary_property(ByteCursor& cursor) { return skip_text(cursor) && skip_bytes(cursor); }

bool is_token(ByteCursor cursor) {
  if (!skip_text(cursor) || !skip_items(cursor, skip_property)) return false;
  return cursor.left() == 0 || skip_items(cursor, skip_binary_property);
}

bool is_filter(ByteCursor cursor) {
  return skip_name(cursor) && skip_name(cursor) && skip_name(cursor) && skip_text(cursor) &&
         skip_items(cursor, skip_name);
}

bool is_value(const Rule& rule, ByteCursor cursor) {
  switch (rule.form) {
    case Form::kFixed:
      return cursor.left() == rule.size;
    case Form::kString:
      return skip_name(cursor);
    case Form::kBytes:
      return skip_bytes(cursor);
    case Form::kNumbers: {
      const std::uint32_t count = cursor.u32();
      return count <= cursor.left() / rule.size;
    }
    case Form::kStrings:
      return skip_items(cursor, skip_name);
    case Form::kProperties:
      return skip_items(cursor, skip_property);
    case Form::kToken:
      return is_token(cursor);
    case Form::kFilter:
      return is_filter(cursor);
  }
  return false;
}

const Rule* rule_of(const Parameter& parameter) {
  const auto* rule = std::ranges::find(kRules, parameter.id, &Rule::id);
  return rule == kRules.end() ? nullptr : rule;
}

bool is_well_formed(const Parameter& parameter, bool is_little_endian) {
  const Rule* rule = rule_of(parameter);
  return rule == nullptr || is_value(*rule, ByteCursor(parameter.value, is_little_endian));
}

/// Seconds in the list's byte order.
BytePatch capped_lease(std::size_t at, bool is_little_endian) {
  constexpr auto kSeconds = static_cast<std::byte>(kLongestLease_s);
  BytePatch patch{at, {}, 4};
  patch.bytes[is_little_endian ? 0 : 3] = kSeconds;
  return patch;
}

void add_patches(const Parameter& parameter, std::size_t at, bool is_little_endian,
                 std::vector<BytePatch>& patches) {
  if (std::ranges::find(kPadded, parameter.id) != kPadded.end())
    patches.push_back({at, {}, 2});  // id 0: padding
  if (parameter.id != kParticipantLease) return;
  const auto seconds = static_cast<std::int32_t>(ByteCursor(parameter.value, is_little_endian).u32());
  if (seconds < 0 || seconds >= kLongestLease_s)
    patches.push_back(capped_lease(at + kParameterHeaderBytes, is_little_endian));
}

}  // namespace

bool is_inline_qos(ByteCursor& cursor) {
  Parameter parameter;
  while (next_parameter(cursor, parameter)) {
    if (parameter.id == kSentinel) return true;
    if (parameter.id == kKeyHash && parameter.value.size() != 16) return false;
    if (parameter.id == kStatusInfo && parameter.value.size() != 4) return false;
  }
  return false;
}

bool is_discovery_payload(std::span<const std::byte> payload, std::size_t at,
                          std::vector<BytePatch>& patches) {
  constexpr std::byte kBigEndianList{0x02};
  constexpr std::byte kLittleEndianList{0x03};
  if (payload.size() < kEncapsulationBytes || payload[0] != std::byte{0}) return false;
  if (payload[1] != kBigEndianList && payload[1] != kLittleEndianList) return false;
  const bool is_little_endian = payload[1] == kLittleEndianList;
  ByteCursor cursor(payload.subspan(kEncapsulationBytes), is_little_endian);
  Parameter parameter;
  while (next_parameter(cursor, parameter)) {
    if (parameter.id == kSentinel) return true;
    if (!is_well_formed(parameter, is_little_endian)) return false;
    add_patches(parameter, at + kEncapsulationBytes + parameter.at, is_little_endian, patches);
  }
  return false;
}

}  // namespace tonus::bus
