#include "services/dashboard/gateway/protocol_check.hpp"

#include <nlohmann/json.hpp>
#include <sstream>
#include <toml++/toml.h>

#include "services/config/checked_table.hpp"
#include "services/config/toml_text.hpp"
#include "services/core/json_text.hpp"
#include "services/protocol/dry_run.hpp"
#include "services/protocol/protocol.hpp"
#include "services/protocol/refusal.hpp"

namespace tonus::dashboard {
namespace {

using nlohmann::json;

constexpr char kSource[] = "protocol";

/// Tables and keys as they stand in the text, whether the checker accepts them or not.
json document_of(const std::string& text) {
  const auto table = config::parse_toml(text, kSource);
  if (!table) return nullptr;
  std::ostringstream out;
  out << toml::json_formatter(*table, toml::format_flags::none);
  return json::parse(out.str(), nullptr, false);
}

json extreme(const char* what, double value, const json& low, double high, const char* unit) {
  return {{"what", what}, {"value", value}, {"low", low}, {"high", high}, {"unit", unit}};
}

json preview_of(const protocol::DryRun& run, protocol::ProtocolKind kind) {
  json extremes = json::array();
  const protocol::Extremes& e = run.extremes;
  if (kind != protocol::ProtocolKind::kRecording) {
    extremes = {extreme("handle from the robot's base, nearest", e.nearest, e.nearest_allowed,
                        e.farthest_allowed, "m"),
                extreme("handle from the robot's base, farthest", e.farthest, e.nearest_allowed,
                        e.farthest_allowed, "m"),
                extreme("bias force", e.bias, nullptr, e.bias_allowed, "N"),
                extreme("force to expect", e.force, nullptr, e.force_allowed, "N")};
    if (e.from_centre_allowed > 0.0)
      extremes.push_back(
          extreme("handle from the workspace's centre", e.from_centre, nullptr, e.from_centre_allowed, "m"));
  }
  json postures = json::array();
  for (const auto& posture : run.plan.postures)
    postures.push_back({{"name", posture.name()}, {"trials", posture.trials()}});
  return {{"trials", run.plan.trials.size()},
          {"duration_s", run.duration},
          {"postures", postures},
          {"extremes", extremes}};
}

json refused(const Error& error) {
  const protocol::Refusal refusal = protocol::refusal_of(error, kSource);
  return {{"key", refusal.key}, {"line", refusal.line}, {"message", refusal.message}};
}

/// On the rig, if there is one; the error is what it cannot do.
Result<json> preview(const protocol::Protocol& protocol, std::uint64_t seed,
                     const std::optional<v1::RigDescription>& rig) {
  if (!rig || protocol.kind == protocol::ProtocolKind::kStudy) return json(nullptr);
  TONUS_TRY_ASSIGN(const auto facts, protocol::facts_of(*rig));
  TONUS_TRY_ASSIGN(const auto run, protocol::dry_run(protocol, facts, seed));
  return preview_of(run, protocol.kind);
}

}  // namespace

std::string check_protocol(const std::string& text, std::uint64_t seed,
                           const std::optional<v1::RigDescription>& rig) {
  json answer{{"is_accepted", false}, {"kind", ""},         {"name", ""},
              {"problem", nullptr},   {"preview", nullptr}, {"document", document_of(text)}};
  const auto protocol = protocol::parse_protocol(text, kSource);
  if (!protocol) {
    answer["problem"] = refused(protocol.error());
    return json_text(answer, -1);
  }
  answer["kind"] = protocol::kind_name(protocol->kind);
  answer["name"] = protocol->name;
  const auto shown = preview(*protocol, seed, rig);
  if (shown) {
    answer["is_accepted"] = true;
    answer["preview"] = *shown;
  } else {
    answer["problem"] = refused(shown.error());
  }
  return json_text(answer, -1);
}

std::string protocol_keys_json() {
  json kinds = json::object();
  for (const protocol::ProtocolKind kind : protocol::kProtocolKinds) {
    json keys = json::array();
    for (const config::Key& key : protocol::protocol_keys(kind)) {
      keys.push_back({{"name", key.name},
                      {"expected", key.expected},
                      {"preset", key.preset},
                      {"is_needed", key.is_needed},
                      {"unit", config::unit_of(key.name)}});
    }
    kinds[protocol::kind_name(kind)] = keys;
  }
  return json_text(kinds, -1);
}

}  // namespace tonus::dashboard
