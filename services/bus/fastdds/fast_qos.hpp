#pragma once

#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include "services/bus/bus.hpp"

/// The bus's options and QoS in Fast DDS's terms; complete, so that no profile file changes them.
namespace tonus::bus {

[[nodiscard]] eprosima::fastdds::dds::DomainParticipantQos fast_participant_qos(const BusOptions& options);
/// Of a discovery server that listens at the interface's address and `port`. It is the server of index 0 of
/// a list of one.
[[nodiscard]] eprosima::fastdds::dds::DomainParticipantQos fast_server_qos(const BusOptions& options,
                                                                           std::uint16_t port);
[[nodiscard]] eprosima::fastdds::dds::DataWriterQos fast_writer_qos(const Qos& qos);
[[nodiscard]] eprosima::fastdds::dds::DataReaderQos fast_reader_qos(const Qos& qos);
[[nodiscard]] eprosima::fastrtps::Duration_t fast_duration(std::chrono::milliseconds time);

}  // namespace tonus::bus
