#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/result.hpp"

/// Who may do what on a secured bus.
namespace tonus::pki {

/// What a program proves to be. A program may write the topics of its identity, and nothing else.
struct Identity {
  std::string_view name;  ///< As runtime::identity_of() has it, and "viewer" and "subject".
  std::span<const std::string_view> writes;
  std::span<const std::string_view> reads;  ///< {"*"}: every topic.
};

/// rig, scheduler, identification, archive, dashboard, operator, viewer, subject.
[[nodiscard]] std::span<const Identity> identities();

/// kInvalidArgument lists the names.
[[nodiscard]] Result<Identity> find_identity(std::string_view name);

/// The identities of a role: "services" has scheduler, identification and archive, each with a key of its
/// own, every other role the identity of its name. kInvalidArgument lists the roles.
[[nodiscard]] Result<std::vector<Identity>> identities_of_role(std::string_view role);

}  // namespace tonus::pki
