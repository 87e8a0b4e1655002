#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "services/pki/certificate.hpp"
#include "services/pki/roles.hpp"

namespace tonus::pki {

/// A certificate that the authority has given out.
struct Issued {
  std::uint64_t serial = 0;
  std::string host;
  std::string identity;
  std::vector<std::string> rigs;  ///< {"*"}: every rig.
  UtcTime end;
  bool is_revoked = false;
  bool is_replaced = false;  ///< A later one of this host and identity takes its place.
};

/// What a host is given.
struct IssueRequest {
  std::string host;
  std::vector<std::string> roles;
  std::vector<std::string> rigs{"*"};
  std::chrono::days validity{365};
};

/// The authority of a secured domain, kept in one folder that belongs on a machine apart from the rig:
///
///     authority.pem  authority.key  dds  issued.json
///     hosts/HOST/    what to copy to that host: runtime/security.hpp
///
/// Files with private keys are for their owner alone. One process at a time.
class Authority {
 public:
  /// Makes the folder. kAlreadyExists: it has an authority; kIo.
  [[nodiscard]] static Result<Authority> create(const std::filesystem::path& folder, const std::string& dds,
                                                std::chrono::days validity, UtcTime now);
  /// kNotFound, kIo, kInvalidArgument name the file.
  [[nodiscard]] static Result<Authority> open(const std::filesystem::path& folder);

  /// Makes keys, certificates and permissions of a host, in place of those that it had of the same identity;
  /// the old ones stay valid until they end or are revoked. Returns the folder to copy.
  [[nodiscard]] Result<std::filesystem::path> issue(const IssueRequest& request, UtcTime now);

  /// New certificates for all that `host` has; empty: of every host. kNotFound: it has none. Returns how
  /// many.
  [[nodiscard]] Result<std::size_t> renew(const std::string& host, std::chrono::days validity, UtcTime now);

  /// Revokes every certificate that the host was given, of one identity or of all (empty), and writes the new
  /// list into every host's folder. kNotFound: there is none to revoke. Returns how many.
  [[nodiscard]] Result<std::size_t> revoke(const std::string& host, const std::string& identity, UtcTime now);

  [[nodiscard]] const std::vector<Issued>& issued() const { return issued_; }
  [[nodiscard]] const std::string& dds() const { return dds_; }
  [[nodiscard]] std::filesystem::path folder() const { return folder_; }

 private:
  Authority(std::filesystem::path folder, std::string dds, KeyPair keys)
      : folder_(std::move(folder)), dds_(std::move(dds)), keys_(std::move(keys)) {}
  [[nodiscard]] Result<void> give(const std::string& host, const Identity& identity,
                                  const std::vector<std::string>& rigs, std::chrono::days validity,
                                  UtcTime now);
  [[nodiscard]] Result<void> write_common(const std::string& host, UtcTime now) const;
  [[nodiscard]] Result<void> save() const;
  [[nodiscard]] std::filesystem::path folder_of(const std::string& host) const {
    return folder_ / "hosts" / host;
  }

  std::filesystem::path folder_;
  std::string dds_;
  KeyPair keys_;
  std::vector<Issued> issued_;
};

}  // namespace tonus::pki
