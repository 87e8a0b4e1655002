#include "services/bus/cyclonedds/cyclone_participant.hpp"

#include <mutex>
#include <utility>

#include "services/bus/cyclonedds/cdr_sertype.hpp"
#include "services/bus/cyclonedds/cyclone_qos.hpp"
#include "services/bus/cyclonedds/socket_filter.hpp"
#include "services/bus/discovery_limits.hpp"

namespace tonus::bus {
namespace {

constexpr dds_domainid_t kFirstInternalDomain = 100000;  // clear of the ids that RTPS knows
// Governance and permissions are checked against the internal id, and name only ids that RTPS knows.
constexpr dds_domainid_t kFirstSecuredDomain = 0;

/// A new domain under the first internal id from `first` on that is free in this process.
dds_entity_t create_domain(const std::string& configuration, dds_domainid_t first, dds_domainid_t& id) {
  dds_entity_t domain = DDS_RETCODE_PRECONDITION_NOT_MET;
  for (id = first; domain == DDS_RETCODE_PRECONDITION_NOT_MET; ++id) {
    domain = dds_create_domain(id, configuration.c_str());
    if (domain >= 0) break;
  }
  return domain;
}

void secure(dds_qos_t* qos, const SecurityFiles& files) {
  const auto load = [qos](const std::string& part, const char* library, const std::string& functions) {
    const std::string name = "dds.sec." + part + ".library.";
    dds_qset_prop(qos, (name + "path").c_str(), library);
    dds_qset_prop(qos, (name + "init").c_str(), ("init_" + functions).c_str());
    dds_qset_prop(qos, (name + "finalize").c_str(), ("finalize_" + functions).c_str());
  };
  const auto add_file = [qos](const char* name, const std::filesystem::path& file) {
    dds_qset_prop(qos, name, ("file:" + file.string()).c_str());
  };
  load("auth", "dds_security_auth", "authentication");
  load("access", "dds_security_ac", "access_control");
  load("crypto", "dds_security_crypto", "crypto");
  add_file("dds.sec.auth.identity_ca", files.authority);
  add_file("dds.sec.auth.identity_certificate", files.certificate);
  add_file("dds.sec.auth.private_key", files.key);
  add_file("org.eclipse.cyclonedds.sec.auth.crl", files.revoked);
  add_file("dds.sec.access.permissions_ca", files.authority);
  add_file("dds.sec.access.governance", files.governance);
  add_file("dds.sec.access.permissions", files.permissions);
}

std::string element(const std::string& name, const std::string& value) {
  return "<" + name + ">" + value + "</" + name + ">";
}

}  // namespace

CycloneEntity::~CycloneEntity() {
  if (entity_ > 0) dds_delete(entity_);
}

CycloneEntity::CycloneEntity(CycloneEntity&& other) noexcept : entity_(std::exchange(other.entity_, 0)) {}

CycloneEntity& CycloneEntity::operator=(CycloneEntity&& other) noexcept {
  std::swap(entity_, other.entity_);
  return *this;
}

std::string cyclone_configuration(const BusOptions& options) {
  const NetworkProfile& network = options.network;
  const bool is_loopback = network.interface_address.starts_with("127.");
  const std::string lease = std::to_string(options.participant_lease.count()) + "ms";
  const std::string announcement =
      std::to_string(announcement_period(options.participant_lease).count()) + "ms";
  std::string peers;
  for (const std::string& peer : network.peers) peers += "<Peer Address=\"" + peer + "\"/>";
  // The addresses have been checked to be numbers and dots.
  return "<CycloneDDS><Domain Id=\"any\"><General><Interfaces><NetworkInterface address=\"" +
         network.interface_address + "\" multicast=\"false\"/></Interfaces>" +
         element("AllowMulticast", "false") +
         (is_loopback ? element("MaxMessageSize", "65500B") + element("FragmentSize", "16000B") : "") +
         "</General><Discovery>" + element("ExternalDomainId", std::to_string(options.domain)) +
         element("ParticipantIndex", "auto") +
         element("MaxAutoParticipantIndex", std::to_string(kMaximumParticipantsPerHost - 1)) +
         element("Peers", peers) + element("LeaseDuration", lease) + element("SPDPInterval", announcement) +
         "</Discovery><Internal>" + element("GenerateKeyhash", "true") +
         "<HeartbeatInterval min=\"2ms\" minsched=\"5ms\" max=\"1s\">10ms</HeartbeatInterval>" +
         element("NackDelay", "1ms") + element("AutoReschedNackDelay", "10ms") +
         element("Watermarks", element("WhcAdaptive", "false") + element("WhcHigh", "16MB")) +
         "</Internal></Domain></CycloneDDS>";
}

CycloneParticipant::CycloneParticipant(CycloneEntity domain, CycloneEntity participant,
                                       std::shared_ptr<CycloneParticipant> owner,
                                       const Partitions& partitions)
    : owner_(std::move(owner)), domain_(std::move(domain)), participant_(std::move(participant)) {
  const CycloneQos qos;
  std::vector<const char*> names;
  for (const std::string& partition : partitions) names.push_back(partition.c_str());
  if (!names.empty()) dds_qset_partition(qos.get(), static_cast<std::uint32_t>(names.size()), names.data());
  publisher_ = CycloneEntity(dds_create_publisher(get(), qos.get(), nullptr));
  subscriber_ = CycloneEntity(dds_create_subscriber(get(), qos.get(), nullptr));
}

std::shared_ptr<CycloneParticipant> CycloneParticipant::beside(std::shared_ptr<CycloneParticipant> owner,
                                                               const Partitions& partitions) {
  return std::shared_ptr<CycloneParticipant>(
      new CycloneParticipant(CycloneEntity(), CycloneEntity(), std::move(owner), partitions));
}

Result<std::shared_ptr<CycloneParticipant>> CycloneParticipant::create(const BusOptions& options) {
  static std::mutex one_at_a_time;  // accept_only_at() finds the new sockets among those of the process
  const std::lock_guard lock(one_at_a_time);
  dds_domainid_t id = 0;
  CycloneEntity domain(create_domain(cyclone_configuration(options),
                                     options.security ? kFirstSecuredDomain : kFirstInternalDomain, id));
  TONUS_TRY_ASSIGN(const std::size_t sockets,
                   accept_only_at(options.network.interface_address, options.domain));
  CycloneQos qos;
  dds_qset_entity_name(qos.get(), options.participant_name.c_str());
  if (options.security) secure(qos.get(), *options.security);
  CycloneEntity participant(domain.get() > 0 ? dds_create_participant(id, qos.get(), nullptr) : domain.get());
  if (participant.get() <= 0 || sockets == 0) {
    return fail(ErrorCode::kUnavailable, "Cyclone DDS: no participant in domain " +
                                             std::to_string(options.domain) + " on " +
                                             options.network.interface_address +
                                             ": is the address this machine's, and are its ports free?");
  }
  const Partitions partitions = options.partition.empty() ? Partitions{} : Partitions{options.partition};
  return std::shared_ptr<CycloneParticipant>(
      new CycloneParticipant(std::move(domain), std::move(participant), nullptr, partitions));
}

Result<CycloneTopic> CycloneParticipant::create_topic(const TopicSpec& spec) {
  ddsi_sertype* type = new CdrSertype(std::string(spec.type_name));
  const std::string name(spec.name);
  CycloneTopic topic;
  topic.entity =
      CycloneEntity(dds_create_topic_sertype(get(), name.c_str(), &type, nullptr, nullptr, nullptr));
  if (topic.entity.get() <= 0) {
    const char* reason = dds_strretcode(-topic.entity.get());
    ddsi_sertype_unref(type);
    return fail(ErrorCode::kInvalidArgument, "topic '" + name + "' of type " + std::string(spec.type_name) +
                                                 ": refused by Cyclone DDS: " + reason);
  }
  topic.type = type;  // the one given, or an equal one that was there
  return topic;
}

}  // namespace tonus::bus
