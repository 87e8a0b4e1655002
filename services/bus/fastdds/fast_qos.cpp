#include "services/bus/fastdds/fast_qos.hpp"

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include "services/bus/discovery_limits.hpp"

namespace tonus::bus {
namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::Duration_t;
using std::chrono::milliseconds;

constexpr std::uint32_t kSocketBufferBytes = 4 * 1024 * 1024;
constexpr milliseconds kHeartbeatPeriod{10};  // the default of 3 s makes every lost packet cost seconds
constexpr milliseconds kHeartbeatResponse{1};

rtps::Locator_t locator(const std::string& address, std::uint32_t port) {
  rtps::Locator_t locator;
  locator.kind = LOCATOR_KIND_UDPv4;
  locator.port = port;
  rtps::IPLocator::setIPv4(locator, address);
  return locator;
}

/// What writers and readers are told alike.
template <typename EndpointQos>
void set_common(EndpointQos& out, const Qos& qos) {
  out.reliability().kind = qos.reliable ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
  out.reliability().max_blocking_time = fast_duration(qos.max_blocking);
  out.durability().kind = qos.durability == Durability::kTransientLocal ? fast::TRANSIENT_LOCAL_DURABILITY_QOS
                                                                        : fast::VOLATILE_DURABILITY_QOS;
  out.history().kind =
      qos.history == History::kKeepAll ? fast::KEEP_ALL_HISTORY_QOS : fast::KEEP_LAST_HISTORY_QOS;
  out.history().depth = qos.depth;
  // Limits on samples in total or on instances would fill up for good: Fast DDS keeps the place of every key
  // that it has seen. So the limit is per key, and FastWriter bounds the total.
  out.resource_limits().max_samples = 0;
  out.resource_limits().max_instances = 0;
  out.resource_limits().max_samples_per_instance = qos.history == History::kKeepAll ? qos.depth : 0;
  out.resource_limits().allocated_samples = 0;
  out.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
  out.data_sharing().off();  // it loses reliable samples without an error
  if (qos.deadline.count() > 0) out.deadline().period = fast_duration(qos.deadline);
  out.liveliness().kind = fast::AUTOMATIC_LIVELINESS_QOS;
  if (qos.liveliness_lease.count() > 0) {
    out.liveliness().lease_duration = fast_duration(qos.liveliness_lease);
    out.liveliness().announcement_period = fast_duration(qos.liveliness_lease * 3 / 10);
  }
}

}  // namespace

Duration_t fast_duration(milliseconds time) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(time);
  return Duration_t(static_cast<std::int32_t>(seconds.count()),
                    static_cast<std::uint32_t>(std::chrono::nanoseconds(time - seconds).count()));
}

fast::DomainParticipantQos fast_participant_qos(const BusOptions& options) {
  fast::DomainParticipantQos qos;
  qos.name(options.participant_name);
  const NetworkProfile& network = options.network;

  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.push_back(network.interface_address);
  udp->maxInitialPeersRange = kMaximumParticipantsPerHost;
  udp->sendBufferSize = kSocketBufferBytes;
  udp->receiveBufferSize = kSocketBufferBytes;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);

  auto& builtin = qos.wire_protocol().builtin;
  // Its own locator keeps it from joining 239.255.0.1. The port is that of the first participant of a host;
  // where it is taken, Fast DDS goes on to the next one's. By itself it would begin with the number of
  // participants that this process ever had, which leads out of the range in which peers look.
  const std::uint32_t first_port =
      rtps::PortParameters().getUnicastPort(static_cast<std::uint32_t>(options.domain), 0);
  builtin.metatrafficUnicastLocatorList.push_back(locator(network.interface_address, first_port));
  constexpr std::uint32_t kEveryPort = 0;  // those of the first kMaximumParticipantsPerHost participants
  for (const std::string& peer : network.peers) builtin.initialPeersList.push_back(locator(peer, kEveryPort));
  auto& discovery = builtin.discovery_config;
  discovery.leaseDuration = fast_duration(options.participant_lease);
  discovery.leaseDuration_announcementperiod = fast_duration(announcement_period(options.participant_lease));
  discovery.initial_announcements.count = 10;
  discovery.initial_announcements.period = fast_duration(milliseconds{20});
  return qos;
}

fast::DataWriterQos fast_writer_qos(const Qos& qos) {
  fast::DataWriterQos out;
  set_common(out, qos);
  out.publish_mode().kind = fast::SYNCHRONOUS_PUBLISH_MODE;
  out.writer_data_lifecycle().autodispose_unregistered_instances = false;
  auto& times = out.reliable_writer_qos().times;
  times.heartbeatPeriod = fast_duration(kHeartbeatPeriod);
  times.nackResponseDelay = fast_duration(kHeartbeatResponse);
  return out;
}

fast::DataReaderQos fast_reader_qos(const Qos& qos) {
  fast::DataReaderQos out;
  set_common(out, qos);
  out.reliable_reader_qos().times.heartbeatResponseDelay = fast_duration(kHeartbeatResponse);
  return out;
}

}  // namespace tonus::bus
