#include "services/pki/authority.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>

#include "services/core/folder.hpp"
#include "services/core/text_file.hpp"
#include "services/pki/documents.hpp"

namespace tonus::pki {
namespace {

constexpr int kSchema = 1;
constexpr std::chrono::minutes kClockError{5};  // of a host whose clock is behind
constexpr mode_t kOwnerAndGroup = 0640;
constexpr mode_t kOwnerAlone = 0600;

Result<void> make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) std::filesystem::permissions(folder, std::filesystem::perms(0750), error);
  if (!error) return {};
  return fail(ErrorCode::kIo, folder.string() + ": cannot be made: " + error.message());
}

/// Written with no right for others at any time.
Result<void> write_private(const std::filesystem::path& file, const std::string& text, mode_t mode) {
  const mode_t before = umask(0777 & ~mode);
  auto written = write_text_file(file, text);
  umask(before);
  return written;
}

Result<void> check_host(const std::string& host) {
  const bool is_good = !host.empty() && host.size() <= 64 && host.front() != '.' && host.front() != '-' &&
                       std::all_of(host.begin(), host.end(), [](unsigned char c) {
                         return std::isalnum(c) != 0 || c == '-' || c == '.' || c == '_';
                       });
  if (is_good) return {};
  return fail(ErrorCode::kInvalidArgument,
              "host '" + host + "' is not allowed; expected letters, digits, '-', '_' and '.', up to 64");
}

Result<void> check_rigs(const std::vector<std::string>& rigs) {
  for (const std::string& rig : rigs) {
    if (rig == "*") continue;
    if (auto good = check_host(rig); !good)
      return fail(ErrorCode::kInvalidArgument,
                  "--rig: '" + rig + "' is not allowed; expected a rig's name or *");
  }
  return {};
}

std::int64_t seconds(UtcTime time) { return std::chrono::system_clock::to_time_t(time); }

nlohmann::json as_json(const Issued& issued) {
  return {{"serial", issued.serial},          {"host", issued.host},
          {"identity", issued.identity},      {"rigs", issued.rigs},
          {"end_utc_s", seconds(issued.end)}, {"is_revoked", issued.is_revoked},
          {"is_replaced", issued.is_replaced}};
}

Issued from_json(const nlohmann::json& json) {
  Issued issued;
  issued.serial = json.at("serial").get<std::uint64_t>();
  issued.host = json.at("host").get<std::string>();
  issued.identity = json.at("identity").get<std::string>();
  issued.rigs = json.at("rigs").get<std::vector<std::string>>();
  issued.end = std::chrono::system_clock::from_time_t(json.at("end_utc_s").get<std::int64_t>());
  issued.is_revoked = json.at("is_revoked").get<bool>();
  issued.is_replaced = json.at("is_replaced").get<bool>();
  return issued;
}

Result<std::vector<Issued>> read_issued(const std::filesystem::path& file) {
  TONUS_TRY_ASSIGN(const auto text, read_text_file(file));
  std::vector<Issued> issued;
  try {
    const auto json = nlohmann::json::parse(text);
    for (const auto& one : json.at("certificates")) issued.push_back(from_json(one));
  } catch (const nlohmann::json::exception& error) {
    return fail(ErrorCode::kInvalidArgument, file.string() + ": cannot be read: " + error.what());
  }
  return issued;
}

}  // namespace

Result<Authority> Authority::create(const std::filesystem::path& folder, const std::string& dds,
                                    std::chrono::days validity, UtcTime now) {
  TONUS_TRY_ASSIGN(const bool is_there, is_present(folder / "authority.key"));
  if (is_there) {
    return fail(ErrorCode::kAlreadyExists,
                folder.string() + " already has an authority; every certificate would become void");
  }
  TONUS_TRY(make_folder(folder / "hosts"));
  TONUS_TRY_ASSIGN(auto keys, make_authority({"tonus authority", 1, now - kClockError, now + validity}));
  TONUS_TRY(write_private(folder / "authority.pem", keys.certificate, kOwnerAndGroup));
  TONUS_TRY(write_private(folder / "dds", dds + "\n", kOwnerAndGroup));
  Authority authority(folder, dds, std::move(keys));
  TONUS_TRY(authority.save());
  TONUS_TRY(write_private(folder / "authority.key", authority.keys_.key, kOwnerAlone));
  return authority;
}

Result<Authority> Authority::open(const std::filesystem::path& folder) {
  TONUS_TRY_ASSIGN(auto certificate, read_text_file(folder / "authority.pem"));
  TONUS_TRY_ASSIGN(auto key, read_text_file(folder / "authority.key"));
  TONUS_TRY_ASSIGN(auto dds, read_text_file(folder / "dds"));
  while (!dds.empty() && dds.back() == '\n') dds.pop_back();
  Authority authority(folder, std::move(dds), {std::move(certificate), std::move(key)});
  TONUS_TRY_ASSIGN(authority.issued_, read_issued(folder / "issued.json"));
  return authority;
}

Result<std::filesystem::path> Authority::issue(const IssueRequest& request, UtcTime now) {
  TONUS_TRY(check_host(request.host));
  TONUS_TRY(check_rigs(request.rigs));
  std::vector<Identity> given;
  for (const std::string& role : request.roles) {
    TONUS_TRY_ASSIGN(const auto identities, identities_of_role(role));
    given.insert(given.end(), identities.begin(), identities.end());
  }
  for (const Identity& identity : given) {
    TONUS_TRY(give(request.host, identity, request.rigs, request.validity, now));
  }
  TONUS_TRY(write_common(request.host, now));
  return folder_of(request.host);
}

Result<void> Authority::give(const std::string& host, const Identity& identity,
                             const std::vector<std::string>& rigs, std::chrono::days validity, UtcTime now) {
  TONUS_TRY_ASSIGN(const auto own, read_certificate(keys_.certificate));
  Issued issued{.serial = issued_.empty() ? 2 : issued_.back().serial + 1,
                .host = host,
                .identity = std::string(identity.name),
                .rigs = rigs,
                .end = std::min(now + validity, own.end)};
  const Subject subject{fmt::format("{}@{}", identity.name, host), issued.serial, now - kClockError,
                        issued.end};
  TONUS_TRY_ASSIGN(const auto keys, make_certificate(subject, keys_));
  TONUS_TRY_ASSIGN(const auto permissions, sign(permissions_document({.subject = subject.common_name,
                                                                      .identity = identity,
                                                                      .rigs = rigs,
                                                                      .begin = subject.begin,
                                                                      .end = subject.end}),
                                                keys_));
  // The register first: a certificate that it does not know could not be revoked.
  for (Issued& earlier : issued_)
    earlier.is_replaced |= earlier.host == issued.host && earlier.identity == issued.identity;
  issued_.push_back(issued);
  TONUS_TRY(save());
  const auto folder = folder_of(host) / issued.identity;
  TONUS_TRY(make_folder(folder_of(host)));
  TONUS_TRY(make_folder(folder));
  TONUS_TRY(write_private(folder / "certificate.pem", keys.certificate, kOwnerAndGroup));
  TONUS_TRY(write_private(folder / "key.pem", keys.key, kOwnerAndGroup));
  return write_private(folder / "permissions.p7s", permissions, kOwnerAndGroup);
}

Result<void> Authority::write_common(const std::string& host, UtcTime now) const {
  std::vector<std::uint64_t> revoked;
  for (const Issued& issued : issued_)
    if (issued.is_revoked) revoked.push_back(issued.serial);
  TONUS_TRY_ASSIGN(const auto governance, sign(governance_document(), keys_));
  TONUS_TRY_ASSIGN(const auto revocations, make_revocations(revoked, now - kClockError, keys_));
  const auto folder = folder_of(host);
  TONUS_TRY(write_private(folder / "authority.pem", keys_.certificate, kOwnerAndGroup));
  TONUS_TRY(write_private(folder / "governance.p7s", governance, kOwnerAndGroup));
  TONUS_TRY(write_private(folder / "revoked.pem", revocations, kOwnerAndGroup));
  return write_private(folder / "dds", dds_ + "\n", kOwnerAndGroup);
}

Result<std::size_t> Authority::renew(const std::string& host, std::chrono::days validity, UtcTime now) {
  std::vector<Issued> current;
  std::set<std::string> hosts;
  for (const Issued& issued : issued_) {
    if (issued.is_revoked || issued.is_replaced || (!host.empty() && issued.host != host)) continue;
    current.push_back(issued);
    hosts.insert(issued.host);
  }
  if (current.empty()) return fail(ErrorCode::kNotFound, "host '" + host + "' has no certificate to renew");
  for (const Issued& issued : current) {
    TONUS_TRY_ASSIGN(const auto identity, find_identity(issued.identity));
    TONUS_TRY(give(issued.host, identity, issued.rigs, validity, now));
  }
  for (const std::string& name : hosts) TONUS_TRY(write_common(name, now));
  return current.size();
}

Result<std::size_t> Authority::revoke(const std::string& host, const std::string& identity, UtcTime now) {
  std::size_t revoked = 0;
  for (Issued& issued : issued_) {
    if (issued.is_revoked || issued.host != host || (!identity.empty() && issued.identity != identity))
      continue;
    issued.is_revoked = true;
    ++revoked;
  }
  if (revoked == 0) {
    return fail(ErrorCode::kNotFound, "host '" + host + "' has no certificate" +
                                          (identity.empty() ? "" : " of identity '" + identity + "'") +
                                          " to revoke");
  }
  TONUS_TRY(save());
  std::set<std::string> hosts;
  for (const Issued& issued : issued_) hosts.insert(issued.host);
  for (const std::string& name : hosts) TONUS_TRY(write_common(name, now));
  return revoked;
}

Result<void> Authority::save() const {
  nlohmann::json json{{"schema", kSchema}, {"certificates", nlohmann::json::array()}};
  for (const Issued& issued : issued_) json["certificates"].push_back(as_json(issued));
  return write_private(folder_ / "issued.json", json.dump(1) + "\n", kOwnerAlone);
}

}  // namespace tonus::pki
