#pragma once

#include <fastdds/dds/topic/TopicDataType.hpp>
#include <functional>
#include <string>

namespace tonus::bus {

/// What Fast DDS takes for a generated type: passes payloads (bus.hpp, Payload) on as they are. Announces the
/// type's name and the key that a generated type would have: the 16 bytes behind the header.
class BytesType final : public eprosima::fastdds::dds::TopicDataType {
 public:
  explicit BytesType(const std::string& type_name);

  bool serialize(void* payload, eprosima::fastrtps::rtps::SerializedPayload_t* wire) override;

  /// Takes whatever came: Fast DDS would ask for a refused sample again and again. The reader checks it.
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* wire, void* payload) override;

  std::function<std::uint32_t()> getSerializedSizeProvider(void* payload) override;
  void* createData() override;
  void deleteData(void* payload) override;
  bool getKey(void* payload, eprosima::fastrtps::rtps::InstanceHandle_t* handle, bool force_md5) override;
};

}  // namespace tonus::bus
