#pragma once

#include <atomic>
#include <cstdint>
#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <memory>

#include "services/bus/fastdds/rtps_check.hpp"

namespace tonus::bus {

/// What the transports of one participant share with its readers. Thread-safe.
struct ReceivedPackets {
  /// Of the readers' topics, the largest sample.
  std::atomic<std::size_t> message_bytes = RtpsLimits{}.message_bytes;

  void allow_message_bytes(std::size_t bytes);
};

/// Puts check_rtps() in front of every transport of the QoS, whatever its kind: what fails is dropped and
/// counted by refused_packets().
void check_packets(eprosima::fastdds::dds::DomainParticipantQos& qos,
                   const std::shared_ptr<ReceivedPackets>& received);

}  // namespace tonus::bus
