// Prints every estimate as it is published: Fast DDS alone, with the types that fastddsgen makes from
// idl/estimate.idl.
//
//   tonus-example-fastdds [DOMAIN [RIG]]

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <memory>

#include "estimatePubSubTypes.h"

namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

volatile std::sig_atomic_t is_ended = 0;

rtps::Locator_t loopback(std::uint32_t port) {
  rtps::Locator_t locator;
  locator.kind = LOCATOR_KIND_UDPv4;
  locator.port = port;
  rtps::IPLocator::setIPv4(locator, "127.0.0.1");
  return locator;
}

/// Unicast on the loopback only, as the services by default: no packet leaves the machine.
fast::DomainParticipantQos confined(std::uint32_t domain) {
  fast::DomainParticipantQos qos;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.push_back("127.0.0.1");
  udp->maxInitialPeersRange = 60;  // of participants on this machine
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  auto& builtin = qos.wire_protocol().builtin;
  builtin.metatrafficUnicastLocatorList.push_back(loopback(rtps::PortParameters().getUnicastPort(domain, 0)));
  builtin.initialPeersList.push_back(loopback(0));
  return qos;
}

/// The reading side of the quality "latest": idl/README.md.
fast::DataReaderQos latest() {
  fast::DataReaderQos qos;
  qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.resource_limits().max_samples = 0;  // as many as there are conditions
  qos.resource_limits().max_instances = 0;
  qos.data_sharing().off();
  return qos;
}

void print(const tonus::v1::Estimate& estimate) {
  const auto& k = estimate.stiffness_N_per_m().value();
  std::printf("%-12s %-15s %3u trials  K = [%8.1f %8.1f; %8.1f %8.1f] N/m\n", estimate.posture().c_str(),
              estimate.method().c_str(), estimate.trials_used(), k[0], k[1], k[2], k[3]);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const auto domain = static_cast<std::uint32_t>(argc > 1 ? std::atoi(argv[1]) : 47);
  std::signal(SIGINT, [](int) { is_ended = 1; });
  std::signal(SIGTERM, [](int) { is_ended = 1; });

  auto* factory = fast::DomainParticipantFactory::get_instance();
  auto* participant = factory->create_participant(domain, confined(domain));
  if (participant == nullptr) {
    std::fprintf(stderr, "no participant in domain %u\n", domain);
    return 1;
  }
  fast::TypeSupport type(new tonus::v1::EstimatePubSubType);
  type.register_type(participant);
  auto* topic =
      participant->create_topic("estimate/condition", type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
  fast::SubscriberQos of_rig;
  of_rig.partition().push_back(argc > 2 ? argv[2] : "rig");  // "*": every rig of the domain
  auto* subscriber = participant->create_subscriber(of_rig);
  auto* reader = subscriber->create_datareader(topic, latest());

  while (is_ended == 0) {
    if (!reader->wait_for_unread_message({0, 200'000'000})) continue;
    tonus::v1::Estimate estimate;
    fast::SampleInfo info;
    while (reader->take_next_sample(&estimate, &info) == ReturnCode_t::RETCODE_OK)
      if (info.valid_data) print(estimate);
  }
  participant->delete_contained_entities();
  factory->delete_participant(participant);
  return 0;
}
