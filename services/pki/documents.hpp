#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "services/pki/roles.hpp"

/// The two documents of DDS Security 1.1 (9.4.1), before they are signed.
namespace tonus::pki {

/// Of a domain: nobody without a certificate takes part, every topic is encrypted, and who writes or reads is
/// checked against permissions.
[[nodiscard]] std::string governance_document();

struct Grant {
  std::string subject;  ///< Common name of the certificate.
  Identity identity;
  std::vector<std::string> rigs;  ///< Partitions; {"*"}: every rig.
  std::chrono::system_clock::time_point begin;
  std::chrono::system_clock::time_point end;
};

/// Of one certificate: what it may write and read; everything else is denied.
[[nodiscard]] std::string permissions_document(const Grant& grant);

}  // namespace tonus::pki
