#include "tests/bench/latency/secured_host.hpp"

#include <array>
#include <chrono>
#include <string_view>

#include "services/core/text_file.hpp"
#include "services/pki/authority.hpp"
#include "services/pki/documents.hpp"

namespace tonus::bench {
namespace {

constexpr std::array<std::string_view, 2> kWrites{"bench/there", "bench/back"};
constexpr std::array<std::string_view, 1> kReads{"*"};
constexpr pki::Identity kBench{"bench", kWrites, kReads};
constexpr std::uint64_t kSerial = 1'000'000;  // far from those that the authority counts
constexpr std::chrono::hours kClockError{1};

}  // namespace

Result<std::string> make_secured_host(const std::filesystem::path& folder, const std::string& dds) {
  const auto now = std::chrono::system_clock::now();
  const auto end = now + std::chrono::days(2);
  TONUS_TRY_ASSIGN(auto authority, pki::Authority::create(folder, dds, std::chrono::days(3), now));
  TONUS_TRY_ASSIGN(const auto host,
                   authority.issue({.host = "host", .roles = {"rig", "services", "operator"}}, now));
  TONUS_TRY_ASSIGN(const auto certificate, read_text_file(folder / "authority.pem"));
  TONUS_TRY_ASSIGN(const auto key, read_text_file(folder / "authority.key"));
  const pki::KeyPair signer{certificate, key};
  TONUS_TRY_ASSIGN(const auto own,
                   pki::make_certificate({"bench@host", kSerial, now - kClockError, end}, signer));
  TONUS_TRY_ASSIGN(
      const auto permissions,
      pki::sign(pki::permissions_document({"bench@host", kBench, {"*"}, now - kClockError, end}), signer));
  std::error_code error;
  std::filesystem::create_directory(host / "bench", error);
  TONUS_TRY(create_text_file(host / "bench" / "certificate.pem", own.certificate));
  TONUS_TRY(create_text_file(host / "bench" / "key.pem", own.key));
  TONUS_TRY(create_text_file(host / "bench" / "permissions.p7s", permissions));
  return host.string();
}

bus::SecurityFiles bench_files(const std::filesystem::path& host) {
  const auto own = host / "bench";
  return {host / "authority.pem", host / "revoked.pem",    own / "certificate.pem",
          own / "key.pem",        host / "governance.p7s", own / "permissions.p7s"};
}

}  // namespace tonus::bench
