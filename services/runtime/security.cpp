#include "services/runtime/security.hpp"

#include <algorithm>
#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "services/core/folder.hpp"
#include "services/core/text_file.hpp"
#include "services/pki/certificate.hpp"

namespace tonus::runtime {
namespace {

constexpr std::pair<const char*, const char*> kIdentities[] = {{"tonus-rig-agent", "rig"},
                                                               {"tonus-scheduler", "scheduler"},
                                                               {"tonus-identification", "identification"},
                                                               {"tonus-archive", "archive"},
                                                               {"tonus-dashboard", "dashboard"}};

Result<void> check_readable(const std::filesystem::path& file) {
  if (auto opened = open_for_reading(file); !opened) {
    return fail(opened.error().code, "--security: " + opened.error().message +
                                         "; expected the folder that `tonus pki issue` made for this host");
  }
  return {};
}

/// The first identity of `wanted` that the folder has.
Result<std::filesystem::path> identity_folder(const std::filesystem::path& folder,
                                              const std::vector<std::string>& wanted) {
  for (const std::string& identity : wanted) {
    TONUS_TRY_ASSIGN(const bool is_there, is_present(folder / identity));
    if (is_there) return folder / identity;
  }
  return fail(ErrorCode::kNotFound,
              fmt::format("--security {}: this host has no identity '{}'; issue it with tonus pki issue",
                          folder.string(), wanted.front()));
}

std::string utc(std::chrono::system_clock::time_point time) {
  return fmt::format("{:%Y-%m-%d %H:%M UTC}", fmt::gmtime(std::chrono::system_clock::to_time_t(time)));
}

}  // namespace

std::string identity_of(const std::string& program) {
  for (const auto& [name, identity] : kIdentities) {
    if (program.starts_with(name)) return identity;
  }
  return "operator";
}

Result<std::optional<bus::SecurityFiles>> security_files(const CommonOptions& options,
                                                         const std::string& program) {
  if (options.security.empty()) return std::optional<bus::SecurityFiles>();
  TONUS_TRY_ASSIGN(const auto folder, absolute_path(options.security));
  auto dds = read_text_file(folder / "dds", 64);
  if (!dds) {
    return fail(dds.error().code, "--security: " + dds.error().message +
                                      "; expected the folder that `tonus pki issue` made for this host");
  }
  while (!dds->empty() && dds->back() == '\n') dds->pop_back();
  if (*dds != options.dds) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("--dds: {} is not allowed in this secured domain; expected {}, as in {}",
                            options.dds, *dds, (folder / "dds").string()));
  }
  std::vector<std::string> wanted{identity_of(program)};
  if (wanted.front() == "operator") wanted.emplace_back("viewer");
  TONUS_TRY_ASSIGN(const auto own, identity_folder(folder, wanted));
  bus::SecurityFiles files{folder / "authority.pem", folder / "revoked.pem",    own / "certificate.pem",
                           own / "key.pem",          folder / "governance.p7s", own / "permissions.p7s"};
  for (const auto& file :
       {files.authority, files.revoked, files.certificate, files.key, files.governance, files.permissions}) {
    TONUS_TRY(check_readable(file));
  }
  return std::optional(std::move(files));
}

Result<void> check_certificate(const bus::SecurityFiles& files, std::chrono::system_clock::time_point now) {
  const auto in_file = [](const std::filesystem::path& file, const Error& error) {
    return fail(error.code, fmt::format("--security {}: {}", file.string(), error.message));
  };
  TONUS_TRY_ASSIGN(const auto certificate, read_text_file(files.certificate));
  const auto state = pki::read_certificate(certificate);
  if (!state) return in_file(files.certificate, state.error());
  TONUS_TRY_ASSIGN(const auto list, read_text_file(files.revoked));
  const auto revoked = pki::read_revocations(list);
  if (!revoked) return in_file(files.revoked, revoked.error());
  std::string why;
  if (std::ranges::find(*revoked, state->serial) != revoked->end())
    why = "is revoked; issue another one with tonus pki issue";
  else if (now >= state->end)
    why = fmt::format("has expired on {}; renew it with tonus pki renew, and copy the host's folder",
                      utc(state->end));
  else if (now < state->begin)
    why = fmt::format("begins on {}, and this host's clock says {}; set the clock", utc(state->begin),
                      utc(now));
  if (why.empty()) return {};
  return fail(ErrorCode::kInvalidArgument, fmt::format("--security {}: the certificate of {} {}",
                                                       files.certificate.string(), state->common_name, why));
}

bool may_command(const CommonOptions& options) {
  const auto files = security_files(options, "tonus");
  return !files || !*files || (*files)->key.parent_path().filename() != "viewer";
}

}  // namespace tonus::runtime
