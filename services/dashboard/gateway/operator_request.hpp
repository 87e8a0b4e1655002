#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "services/core/id.hpp"
#include "services/core/result.hpp"
#include "services/dashboard/gateway/access.hpp"

#include <idl/rig.h>
#include <idl/session.h>

/// What an operator asks from a page, as JSON on the topic operator/request:
///
///     {"request_id": "<32 hex digits>", "request": "start", "session_id": "<32 hex digits>",
///      "protocol_toml": "...", "subject": "sub-01", "seed": 1}
///
/// request: start, pause, resume, abort, reject_trial, note (of a session; session_id may be left out but
/// with start), emergency_stop, clear_fault (with the "hold_number" of the rig's state), abort_trial (of the
/// rig). The answer comes on operator/reply with the same request_id. A request that is repeated with its id
/// is done once. A start may have "subject_facts" (services/contract/subject_json.hpp), "study" and
/// "is_pilot". A rejection has "trial_id" and "text", why; a note "text", and if wanted "trial_id" and
/// "note_kind": note or marker. Both texts are one line of at most 1000 bytes. Optional: "by", the operator's
/// name, at most 40 characters of letters, digits, spaces and .'_-; "page", the name of the page, lower-case
/// letters. Both go into requested_by, a stop's with the gateway's time: "Anna, dashboard 127.0.0.1:5000 on
/// results at 11:19:32 UTC".
namespace tonus::dashboard {

using OperatorCommand = std::variant<v1::SessionCommand, v1::RigCommand>;

struct OperatorRequest {
  Id id{};
  std::string name;  ///< "start", ...
  std::string requested_by;
  OperatorCommand command;
};

struct OperatorReply {
  Id id{};
  std::string name;
  bool is_done = false;
  std::string message;
  std::string requested_by;
};

/// Who asks, and which rig the gateway belongs to.
struct Asker {
  Role role = Role::kView;
  std::string name;  ///< For requested_by: "dashboard 127.0.0.1:41000".
  Id rig{};
  std::uint64_t utc_ns = 0;  ///< When the request came; 0: not told.
};

/// kInvalidArgument names what is wrong. `id` is set as soon as it could be read, so that also a refusal can
/// be answered.
[[nodiscard]] Result<OperatorRequest> parse_request(std::string_view json, const Asker& asker, Id& id,
                                                    std::string& name);

/// Whether a role may ask for it: a viewer may stop the rig, and nothing else.
[[nodiscard]] bool is_allowed(Role role, std::string_view request_name);

[[nodiscard]] std::string reply_text(const OperatorReply& reply);

}  // namespace tonus::dashboard
