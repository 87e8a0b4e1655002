#include "services/bus/fastdds/fast_participant.hpp"

#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fastrtps/attributes/LibrarySettingsAttributes.h>
#include <fastrtps/xmlparser/XMLProfileManager.h>

#include "services/bus/fastdds/bytes_type.hpp"
#include "services/bus/fastdds/fast_qos.hpp"

namespace tonus::bus {
namespace {

/// Two participants of one process talk as those of two do. Delivery by direct call would ignore the writer's
/// blocking time. The setting is the library's own global state and has to precede the first participant.
void turn_off_delivery_by_call() {
  static std::once_flag done;
  std::call_once(done, [] {
    eprosima::fastrtps::LibrarySettingsAttributes settings;
    settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
    eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
  });
}

template <typename GroupQos>
GroupQos in_partitions(GroupQos qos, const Partitions& partitions) {
  for (const std::string& partition : partitions) qos.partition().push_back(partition.c_str());
  return qos;
}

}  // namespace

Result<std::shared_ptr<FastParticipant>> FastParticipant::create(const BusOptions& options) {
  return create(options, fast_participant_qos(options));
}

Result<std::shared_ptr<FastParticipant>> FastParticipant::create(const BusOptions& options,
                                                                 fast::DomainParticipantQos qos) {
  turn_off_delivery_by_call();
  auto received = std::make_shared<ReceivedPackets>();
  check_packets(qos, received);
  auto* participant = fast::DomainParticipantFactory::get_instance()->create_participant(
      static_cast<fast::DomainId_t>(options.domain), qos, nullptr, fast::StatusMask::none());
  if (participant == nullptr) {
    return fail(ErrorCode::kUnavailable, "Fast DDS: no participant in domain " +
                                             std::to_string(options.domain) + " on " +
                                             options.network.interface_address +
                                             ": is the address this machine's, and are its ports free?");
  }
  const Partitions partitions = options.partition.empty() ? Partitions{} : Partitions{options.partition};
  return std::shared_ptr<FastParticipant>(
      new FastParticipant(participant, partitions, std::move(received), nullptr));
}

std::shared_ptr<FastParticipant> FastParticipant::beside(std::shared_ptr<FastParticipant> owner,
                                                         const Partitions& partitions) {
  auto* participant = owner->participant_;
  auto received = owner->received_;
  return std::shared_ptr<FastParticipant>(
      new FastParticipant(participant, partitions, std::move(received), std::move(owner)));
}

FastParticipant::FastParticipant(fast::DomainParticipant* participant, const Partitions& partitions,
                                 std::shared_ptr<ReceivedPackets> received,
                                 std::shared_ptr<FastParticipant> owner)
    : owner_(std::move(owner)),
      received_(std::move(received)),
      participant_(participant),
      publisher_(participant->create_publisher(in_partitions(fast::PUBLISHER_QOS_DEFAULT, partitions))),
      subscriber_(participant->create_subscriber(in_partitions(fast::SUBSCRIBER_QOS_DEFAULT, partitions))) {}

FastParticipant::~FastParticipant() {
  participant_->delete_publisher(publisher_);
  participant_->delete_subscriber(subscriber_);
  if (owner_) return;
  for (const auto& [name, topic] : topics_) participant_->delete_topic(topic);
  fast::DomainParticipantFactory::get_instance()->delete_participant(participant_);
}

Result<void> FastParticipant::register_type(const std::string& type_name) {
  if (!participant_->find_type(type_name).empty()) return {};
  const fast::TypeSupport type(new BytesType(type_name));
  if (participant_->register_type(type) == ReturnCode_t::RETCODE_OK) return {};
  return fail(ErrorCode::kInternal, "Fast DDS: type '" + type_name + "' could not be registered");
}

Result<fast::Topic*> FastParticipant::topic(const TopicSpec& spec) {
  if (owner_) return owner_->topic(spec);
  const std::lock_guard lock(mutex_);
  const std::string name(spec.name);
  const std::string type_name(spec.type_name);
  if (const auto known = topics_.find(name); known != topics_.end()) {
    if (known->second->get_type_name() == type_name) return known->second;
    return fail(ErrorCode::kInvalidArgument, "topic '" + name + "': has type " +
                                                 known->second->get_type_name() + " here already, not " +
                                                 type_name);
  }
  if (auto registered = register_type(type_name); !registered) return registered.error();
  fast::Topic* topic = participant_->create_topic(name, type_name, fast::TOPIC_QOS_DEFAULT);
  if (topic == nullptr)
    return fail(ErrorCode::kInternal, "Fast DDS: topic '" + name + "' could not be created");
  topics_.emplace(name, topic);
  return topic;
}

}  // namespace tonus::bus
