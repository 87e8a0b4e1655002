#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "services/bus/bus.hpp"
#include "services/core/result.hpp"
#include "services/runtime/options.hpp"

namespace tonus::runtime {

/// The identity that a program takes on a secured bus: "rig", "scheduler", "identification", "archive",
/// "dashboard", or "operator" for the command line and all else. `program` may have more words behind it.
[[nodiscard]] std::string identity_of(const std::string& program);

/// What is in a host's folder of certificates (`tonus pki issue`):
///
///     authority.pem  revoked.pem  governance.p7s    of the domain
///     dds                                           the one implementation that the domain uses
///     IDENTITY/certificate.pem  key.pem  permissions.p7s
///
/// None without `--security`. The command line takes the identity "viewer" where there is no "operator".
/// kInvalidArgument, kNotFound or kIo name the file and what to do: another implementation, an
/// identity that this host was not given, a file that cannot be read.
[[nodiscard]] Result<std::optional<bus::SecurityFiles>> security_files(const CommonOptions& options,
                                                                       const std::string& program);

/// Whether the others of the domain will take the certificate at the time `now`. kInvalidArgument names the
/// file and what to do: it has ended, it begins later, the authority has revoked it, or it is none.
[[nodiscard]] Result<void> check_certificate(const bus::SecurityFiles& files,
                                             std::chrono::system_clock::time_point now);

/// Whether a program on the command line may command: not where its identity on a secured bus is a viewer's.
[[nodiscard]] bool may_command(const CommonOptions& options);

}  // namespace tonus::runtime
