#include "services/pki/documents.hpp"

#include <ctime>
#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

namespace tonus::pki {
namespace {

// Every domain that both vendors take. Domains are kept apart by their ports and by their authority.
constexpr char kDomains[] = "<domains><id_range><min>0</min><max>230</max></id_range></domains>";

std::string utc(std::chrono::system_clock::time_point time) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(time)));
}

template <typename Names>
std::string list(const char* group, const char* element, const Names& names) {
  std::string text = fmt::format("<{}>", group);
  for (const auto& name : names) text += fmt::format("<{0}>{1}</{0}>", element, name);
  return text + fmt::format("</{}>", group);
}

}  // namespace

std::string governance_document() {
  return std::string(R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
<domain_access_rules><domain_rule>)") +
         kDomains + R"(
<allow_unauthenticated_participants>false</allow_unauthenticated_participants>
<enable_join_access_control>true</enable_join_access_control>
<discovery_protection_kind>ENCRYPT</discovery_protection_kind>
<liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
<rtps_protection_kind>NONE</rtps_protection_kind>
<topic_access_rules><topic_rule>
<topic_expression>*</topic_expression>
<enable_discovery_protection>true</enable_discovery_protection>
<enable_liveliness_protection>true</enable_liveliness_protection>
<enable_read_access_control>true</enable_read_access_control>
<enable_write_access_control>true</enable_write_access_control>
<metadata_protection_kind>ENCRYPT</metadata_protection_kind>
<data_protection_kind>NONE</data_protection_kind>
</topic_rule></topic_access_rules>
</domain_rule></domain_access_rules>
</dds>
)";
}

std::string permissions_document(const Grant& grant) {
  const std::string partitions = list("partitions", "partition", grant.rigs);
  return fmt::format(R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
<permissions><grant name="{0}">
<subject_name>CN={0}</subject_name>
<validity><not_before>{1}</not_before><not_after>{2}</not_after></validity>
<allow_rule>{3}
<publish>{4}{6}</publish>
<subscribe>{5}{6}</subscribe>
</allow_rule>
<default>DENY</default>
</grant></permissions>
</dds>
)",
                     grant.subject, utc(grant.begin), utc(grant.end), kDomains,
                     list("topics", "topic", grant.identity.writes),
                     list("topics", "topic", grant.identity.reads), partitions);
}

}  // namespace tonus::pki
