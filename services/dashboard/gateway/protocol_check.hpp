#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <idl/rig.h>

namespace tonus::dashboard {

/// What the checker says of a protocol's text, and what a session of it would do, as JSON
///
///     {"is_accepted", "kind", "name", "problem": {"key", "line", "message"} or null,
///      "document": the text's tables and keys, null where it is not TOML,
///      "preview": {"trials", "duration_s", "postures": [{"name", "trials"}],
///                  "extremes": [{"what", "value", "low", "high", "unit"}]} or null}
///
/// The preview is of one session with this seed on the rig of the description: without one, of a study, and
/// of a protocol that is refused it is null. A protocol that the rig cannot run is refused. "low" of an
/// extreme may be null. The checker is services/protocol; a study's files are not looked at.
[[nodiscard]] std::string check_protocol(const std::string& text, std::uint64_t seed,
                                         const std::optional<v1::RigDescription>& rig);

/// Every key of a protocol of each kind, as the checker asks for it:
/// {"unloaded": [{"name", "expected", "preset", "is_needed", "unit"}], ...}
[[nodiscard]] std::string protocol_keys_json();

}  // namespace tonus::dashboard
