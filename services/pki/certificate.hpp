#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "services/core/result.hpp"

/// X.509 certificates, lists of revoked ones, and signed documents, by OpenSSL. Keys are on the curve P-256,
/// which both DDS vendors take.
namespace tonus::pki {

using UtcTime = std::chrono::system_clock::time_point;

/// A certificate and its private key, PEM.
struct KeyPair {
  std::string certificate;
  std::string key;
};

struct Subject {
  std::string common_name;
  std::uint64_t serial = 0;
  UtcTime begin;
  UtcTime end;
};

/// A certificate that signs itself, and may sign others.
[[nodiscard]] Result<KeyPair> make_authority(const Subject& subject);

/// A key and a certificate for it, signed by the authority.
[[nodiscard]] Result<KeyPair> make_certificate(const Subject& subject, const KeyPair& authority);

/// A list of revoked certificates, PEM, signed by the authority; valid from now to the authority's end.
[[nodiscard]] Result<std::string> make_revocations(const std::vector<std::uint64_t>& serials, UtcTime now,
                                                   const KeyPair& authority);

/// The document as S/MIME with the authority's signature.
[[nodiscard]] Result<std::string> sign(const std::string& document, const KeyPair& authority);

struct CertificateState {
  std::string common_name;
  std::uint64_t serial = 0;
  UtcTime begin;
  UtcTime end;
};

/// What a PEM text says. kInvalidArgument: it is no certificate.
[[nodiscard]] Result<CertificateState> read_certificate(const std::string& pem);

/// Serial numbers of a list of revoked certificates. kInvalidArgument: it is none.
[[nodiscard]] Result<std::vector<std::uint64_t>> read_revocations(const std::string& pem);

}  // namespace tonus::pki
