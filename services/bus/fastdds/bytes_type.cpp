#include "services/bus/fastdds/bytes_type.hpp"

#include <algorithm>
#include <cstring>

#include "services/bus/payload.hpp"

namespace tonus::bus {
namespace {

using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;

Payload& as_payload(void* data) { return *static_cast<Payload*>(data); }

}  // namespace

BytesType::BytesType(const std::string& type_name) {
  setName(type_name.c_str());
  m_typeSize = kMinimumPayloadBytes;  // histories allocate each sample by its own size
  m_isGetKeyDefined = true;
  auto_fill_type_information(false);
  auto_fill_type_object(false);
}

bool BytesType::serialize(void* payload, SerializedPayload_t* wire) {
  const Payload& bytes = as_payload(payload);
  if (bytes.size() > wire->max_size) return false;
  std::memcpy(wire->data, bytes.data(), bytes.size());
  wire->length = static_cast<std::uint32_t>(bytes.size());
  wire->encapsulation = CDR_LE;
  return true;
}

bool BytesType::deserialize(SerializedPayload_t* wire, void* payload) {
  const auto* begin = reinterpret_cast<const std::byte*>(wire->data);
  as_payload(payload).assign(begin, begin + wire->length);
  return true;
}

std::function<std::uint32_t()> BytesType::getSerializedSizeProvider(void* payload) {
  return [size = static_cast<std::uint32_t>(as_payload(payload).size())] { return size; };
}

void* BytesType::createData() { return new Payload(); }

void BytesType::deleteData(void* payload) { delete static_cast<Payload*>(payload); }

bool BytesType::getKey(void* payload, InstanceHandle_t* handle, bool /*force_md5*/) {
  const Key key = payload_key(as_payload(payload));
  std::copy(key.begin(), key.end(), static_cast<std::uint8_t*>(handle->value));
  return true;
}

}  // namespace tonus::bus
