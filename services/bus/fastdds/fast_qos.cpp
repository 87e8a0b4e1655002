#include "services/bus/fastdds/fast_qos.hpp"

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <sstream>

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
constexpr char kHexDigits[] = "0123456789abcdef";

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

namespace {

/// The server's identity by its place in the list, as eProsima's own tool gives it.
rtps::GuidPrefix_t server_prefix(std::size_t index) {
  rtps::GuidPrefix_t prefix;
  std::istringstream("44.53." + std::string(1, kHexDigits[index / 16]) + kHexDigits[index % 16] +
                     ".5f.45.50.52.4f.53.49.4d.41") >>
      prefix;
  return prefix;
}

void ask_servers(rtps::DiscoverySettings& discovery, const std::vector<DiscoveryServerAddress>& servers) {
  discovery.discoveryProtocol = rtps::DiscoveryProtocol_t::CLIENT;
  discovery.discoveryServer_client_syncperiod = fast_duration(milliseconds{100});
  for (std::size_t i = 0; i < servers.size(); ++i) {
    rtps::RemoteServerAttributes server;
    server.guidPrefix = server_prefix(i);
    server.metatrafficUnicastLocatorList.push_back(locator(servers[i].address, servers[i].port));
    discovery.m_DiscoveryServers.push_back(server);
  }
}

void secure(fast::DomainParticipantQos& qos, const SecurityFiles& files) {
  const auto add = [&qos](const std::string& name, const std::string& value) {
    qos.properties().properties().emplace_back(name, value);
  };
  const auto add_file = [&add](const std::string& name, const std::filesystem::path& file) {
    add(name, "file://" + file.string());
  };
  add("dds.sec.auth.plugin", "builtin.PKI-DH");
  add_file("dds.sec.auth.builtin.PKI-DH.identity_ca", files.authority);
  add_file("dds.sec.auth.builtin.PKI-DH.identity_certificate", files.certificate);
  add_file("dds.sec.auth.builtin.PKI-DH.identity_crl", files.revoked);
  add_file("dds.sec.auth.builtin.PKI-DH.private_key", files.key);
  add("dds.sec.access.plugin", "builtin.Access-Permissions");
  add_file("dds.sec.access.builtin.Access-Permissions.permissions_ca", files.authority);
  add_file("dds.sec.access.builtin.Access-Permissions.governance", files.governance);
  add_file("dds.sec.access.builtin.Access-Permissions.permissions", files.permissions);
  add("dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC");
}

/// What participants and servers have alike: transport, interface, lease, security.
fast::DomainParticipantQos confined_qos(const BusOptions& options) {
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

  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  discovery.leaseDuration = fast_duration(options.participant_lease);
  discovery.leaseDuration_announcementperiod = fast_duration(announcement_period(options.participant_lease));
  discovery.initial_announcements.count = 10;
  discovery.initial_announcements.period = fast_duration(milliseconds{20});
  if (options.security) secure(qos, *options.security);
  return qos;
}

}  // namespace

fast::DomainParticipantQos fast_participant_qos(const BusOptions& options) {
  fast::DomainParticipantQos qos = confined_qos(options);
  const NetworkProfile& network = options.network;
  auto& builtin = qos.wire_protocol().builtin;
  // Its own locator keeps it from joining 239.255.0.1. The port is that of the first participant of a host;
  // where it is taken, Fast DDS goes on to the next one's. By itself it would begin with the number of
  // participants that this process ever had, which leads out of the range in which peers look.
  const std::uint32_t first_port =
      rtps::PortParameters().getUnicastPort(static_cast<std::uint32_t>(options.domain), 0);
  builtin.metatrafficUnicastLocatorList.push_back(locator(network.interface_address, first_port));
  constexpr std::uint32_t kEveryPort = 0;  // those of the first kMaximumParticipantsPerHost participants
  for (const std::string& peer : network.peers) builtin.initialPeersList.push_back(locator(peer, kEveryPort));
  if (!network.discovery_servers.empty()) ask_servers(builtin.discovery_config, network.discovery_servers);
  return qos;
}

fast::DomainParticipantQos fast_server_qos(const BusOptions& options, std::uint16_t port) {
  fast::DomainParticipantQos qos = confined_qos(options);
  qos.wire_protocol().prefix = server_prefix(0);
  auto& builtin = qos.wire_protocol().builtin;
  builtin.metatrafficUnicastLocatorList.push_back(locator(options.network.interface_address, port));
  builtin.discovery_config.discoveryProtocol = rtps::DiscoveryProtocol_t::SERVER;
  builtin.discovery_config.discoveryServer_client_syncperiod = fast_duration(milliseconds{100});
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
