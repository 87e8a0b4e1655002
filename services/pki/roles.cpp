#include "services/pki/roles.hpp"

#include <algorithm>
#include <array>

namespace tonus::pki {
namespace {

using std::string_view;

constexpr std::array<string_view, 1> kEverything{"*"};

// What every service says of itself, and then what is its own.
constexpr std::array<string_view, 12> kRig{
    "service/health", "service/configuration", "clock/echo", "rig/description",   "rig/state",
    "rig/samples",    "rig/auxiliary",         "rig/timing", "rig/flight_record", "rig/reply",
    "rig/stopped",    "trial/outcome"};
constexpr std::array<string_view, 12> kScheduler{
    "service/health", "service/configuration", "clock/echo",   "rig/command",
    "rig/lease",      "trial/command",         "session/plan", "session/state",
    "session/reply",  "session/cue",           "trial/review", "session/note"};
constexpr std::array<string_view, 7> kIdentification{
    "service/health", "service/configuration", "clock/echo",    "trial/verdict",
    "estimate/live",  "estimate/condition",    "archive/resend"};
constexpr std::array<string_view, 7> kArchive{"service/health",  "service/configuration", "clock/echo",
                                              "archive/receipt", "archive/resend",        "clock/probe",
                                              "clock/offset"};
constexpr std::array<string_view, 6> kDashboard{"service/health",  "service/configuration", "clock/echo",
                                                "session/command", "rig/command",           "rig/stop"};
constexpr std::array<string_view, 3> kOperator{"session/command", "rig/command", "rig/stop"};
constexpr std::array<string_view, 1> kStop{"rig/stop"};
// What the subject's page shows: the cue, the hand, and whether the stop has been confirmed.
constexpr std::array<string_view, 5> kSubjectReads{"session/cue", "rig/description", "rig/state",
                                                   "rig/samples", "rig/stopped"};

constexpr std::array kIdentities{Identity{"rig", kRig, kEverything},
                                 Identity{"scheduler", kScheduler, kEverything},
                                 Identity{"identification", kIdentification, kEverything},
                                 Identity{"archive", kArchive, kEverything},
                                 Identity{"dashboard", kDashboard, kEverything},
                                 Identity{"operator", kOperator, kEverything},
                                 Identity{"viewer", kStop, kEverything},
                                 Identity{"subject", kStop, kSubjectReads}};
constexpr std::array<string_view, 3> kServices{"scheduler", "identification", "archive"};
constexpr char kRoles[] = "rig, services, dashboard, operator, viewer or subject";

}  // namespace

std::span<const Identity> identities() { return kIdentities; }

Result<Identity> find_identity(string_view name) {
  const auto found = std::find_if(kIdentities.begin(), kIdentities.end(),
                                  [&](const Identity& identity) { return identity.name == name; });
  if (found != kIdentities.end()) return *found;
  return fail(ErrorCode::kInvalidArgument, "identity '" + std::string(name) +
                                               "' is not allowed; expected rig, scheduler, identification, "
                                               "archive, dashboard, operator, viewer or subject");
}

Result<std::vector<Identity>> identities_of_role(string_view role) {
  std::vector<Identity> of_role;
  const bool is_services = role == "services";
  for (const Identity& identity : kIdentities) {
    const bool is_service = std::find(kServices.begin(), kServices.end(), identity.name) != kServices.end();
    if (is_services ? is_service : identity.name == role && !is_service) of_role.push_back(identity);
  }
  if (of_role.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "--role: '" + std::string(role) + "' is not allowed; expected " + kRoles);
  }
  return of_role;
}

}  // namespace tonus::pki
