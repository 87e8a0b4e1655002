#pragma once

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "services/bus/bus.hpp"
#include "services/bus/fastdds/checked_transport.hpp"
#include "services/bus/partitions.hpp"

namespace tonus::bus {

namespace fast = eprosima::fastdds::dds;

/// One Fast DDS participant with its publisher, subscriber and topics; writers and readers share it and it
/// goes with the last of them. Thread-safe.
class FastParticipant {
 public:
  [[nodiscard]] static Result<std::shared_ptr<FastParticipant>> create(const BusOptions& options);
  /// With another QoS than fast_participant_qos(): a discovery server's.
  [[nodiscard]] static Result<std::shared_ptr<FastParticipant>> create(const BusOptions& options,
                                                                       fast::DomainParticipantQos qos);
  /// The same participant, with a publisher and a subscriber in other partitions.
  [[nodiscard]] static std::shared_ptr<FastParticipant> beside(std::shared_ptr<FastParticipant> owner,
                                                               const Partitions& partitions);
  ~FastParticipant();
  FastParticipant(const FastParticipant&) = delete;
  FastParticipant& operator=(const FastParticipant&) = delete;

  /// The topic's one object in this participant; kept until the participant goes. kInvalidArgument when its
  /// name is there with another type.
  [[nodiscard]] Result<fast::Topic*> topic(const TopicSpec& spec);
  [[nodiscard]] fast::Publisher& publisher() { return *publisher_; }
  [[nodiscard]] fast::Subscriber& subscriber() { return *subscriber_; }
  [[nodiscard]] ReceivedPackets& received() { return *received_; }

 private:
  FastParticipant(fast::DomainParticipant* participant, const Partitions& partitions,
                  std::shared_ptr<ReceivedPackets> received, std::shared_ptr<FastParticipant> owner);
  [[nodiscard]] Result<void> register_type(const std::string& type_name);

  std::shared_ptr<FastParticipant> owner_;  ///< Of participant and topics; none: this one.
  std::shared_ptr<ReceivedPackets> received_;
  fast::DomainParticipant* participant_;
  fast::Publisher* publisher_;
  fast::Subscriber* subscriber_;
  std::mutex mutex_;
  std::map<std::string, fast::Topic*> topics_;
};

}  // namespace tonus::bus
