#pragma once

#include <string>

#include "analysis_service/muscles/trial_activity.hpp"

namespace tonus::identification {

/// What a session's protocol, as its plan has the text, says of muscles. Of a text that is no protocol:
/// nothing.
[[nodiscard]] muscles::MuscleSettings muscle_settings_of(const std::string& protocol_toml);

}  // namespace tonus::identification
