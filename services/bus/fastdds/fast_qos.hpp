#pragma once

#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include "services/bus/bus.hpp"

/// The bus's options and QoS in Fast DDS's terms; complete, so that no profile file changes them.
namespace tonus::bus {

[[nodiscard]] eprosima::fastdds::dds::DomainParticipantQos fast_participant_qos(const BusOptions& options);
[[nodiscard]] eprosima::fastdds::dds::DataWriterQos fast_writer_qos(const Qos& qos);
[[nodiscard]] eprosima::fastdds::dds::DataReaderQos fast_reader_qos(const Qos& qos);
[[nodiscard]] eprosima::fastrtps::Duration_t fast_duration(std::chrono::milliseconds time);

}  // namespace tonus::bus
