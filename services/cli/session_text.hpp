#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "services/store/session_reader.hpp"

/// An archived session as a person reads it, and as programs do.
namespace tonus::cli {

/// Plan, trials with verdicts and reasons, certificates, estimates with units, rig, configurations, clocks.
[[nodiscard]] std::string session_text(const store::Session& session);

/// `{"schema": 1, "session": ..., "trials": [...], "conditions": [...], ...}`; conditions as the result of an
/// identification has them; units in the keys.
[[nodiscard]] nlohmann::json session_json(const store::Session& session);

}  // namespace tonus::cli
