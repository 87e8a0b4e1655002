#include "analysis_service/service/muscle_settings.hpp"

#include "services/protocol/protocol.hpp"

namespace tonus::identification {

muscles::MuscleSettings muscle_settings_of(const std::string& protocol_toml) {
  const auto protocol = protocol::parse_protocol(protocol_toml, "protocol");
  if (!protocol) return {};
  muscles::MuscleSettings settings;
  settings.most_activity = protocol->muscles.most_activity;
  for (const auto& pair : protocol->muscles.antagonists)
    settings.antagonists.emplace_back(pair.first, pair.second);
  return settings;
}

}  // namespace tonus::identification
