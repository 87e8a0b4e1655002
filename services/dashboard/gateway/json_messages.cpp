#include "services/dashboard/gateway/json_messages.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/contract/message_json.hpp"
#include "services/core/json_text.hpp"

namespace tonus::dashboard {
namespace {

using nlohmann::json;
using Payload = std::span<const std::byte>;

struct Speaker {
  std::string_view topic;
  Result<json> (*speak)(Payload payload);
};

template <typename T>
Result<json> speak(Payload payload) {
  TONUS_TRY_ASSIGN(const auto message, bus::decode<T>(payload));
  return contract::message_json(message);
}

constexpr std::array kSpeakers{Speaker{topics::kEstimateCondition.spec.name, &speak<v1::Estimate>},
                               Speaker{topics::kEstimateLive.spec.name, &speak<v1::Estimate>},
                               Speaker{topics::kTrialVerdict.spec.name, &speak<v1::TrialVerdict>},
                               Speaker{topics::kTrialOutcome.spec.name, &speak<v1::TrialOutcome>},
                               Speaker{topics::kTrialReview.spec.name, &speak<v1::TrialReview>},
                               Speaker{topics::kSessionPlan.spec.name, &speak<v1::SessionPlan>},
                               Speaker{topics::kSessionState.spec.name, &speak<v1::SessionState>},
                               Speaker{topics::kSessionNote.spec.name, &speak<v1::SessionNote>},
                               Speaker{topics::kRigState.spec.name, &speak<v1::RigState>},
                               Speaker{topics::kRigDescription.spec.name, &speak<v1::RigDescription>}};

constexpr auto kNames = [] {
  std::array<std::string_view, kSpeakers.size()> names;
  std::transform(kSpeakers.begin(), kSpeakers.end(), names.begin(), [](const Speaker& s) { return s.topic; });
  return names;
}();

Error unknown(std::string_view topic) {
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("topic '{:.80}' is not allowed; expected one or more of {}", topic,
                          fmt::join(kNames, ", ")));
}

}  // namespace

std::span<const std::string_view> json_topics() { return kNames; }

Result<std::string> json_message(std::string_view topic, std::uint64_t time_ns, Payload payload) {
  const auto speaker = std::find_if(kSpeakers.begin(), kSpeakers.end(),
                                    [&](const Speaker& candidate) { return candidate.topic == topic; });
  if (speaker == kSpeakers.end()) return unknown(topic);
  TONUS_TRY_ASSIGN(auto message, speaker->speak(payload));
  return json_text_of(topic, time_ns, std::move(message));
}

std::string json_text_of(std::string_view topic, std::uint64_t time_ns, json message) {
  return json_text(json{{"topic", topic}, {"time_ns", time_ns}, {"message", std::move(message)}}, -1);
}

Result<std::vector<std::string_view>> json_topics_of(std::string_view query) {
  if (query.empty()) return std::vector<std::string_view>(kNames.begin(), kNames.end());
  std::vector<std::string_view> wanted;
  while (true) {
    const auto comma = query.find(',');
    const auto known = std::find(kNames.begin(), kNames.end(), query.substr(0, comma));
    if (known == kNames.end()) return unknown(query.substr(0, comma));
    if (std::find(wanted.begin(), wanted.end(), *known) == wanted.end()) wanted.push_back(*known);
    if (comma == std::string_view::npos) return wanted;
    query.remove_prefix(comma + 1);
  }
}

std::vector<std::string_view> topics_of_path(std::string_view path) {
  if (path == "/api/estimates") return {topics::kEstimateCondition.spec.name};
  if (path == "/api/verdicts") return {topics::kTrialVerdict.spec.name};
  if (path == "/api/reviews") return {topics::kTrialReview.spec.name};
  if (path == "/api/notes") return {topics::kSessionNote.spec.name};
  if (path == "/api/rigs") return {topics::kRigDescription.spec.name};
  if (path == "/api/outcomes") return {topics::kTrialOutcome.spec.name};
  if (path == "/api/plans") return {topics::kSessionPlan.spec.name};
  if (path == "/api/states") return {topics::kSessionState.spec.name, topics::kRigState.spec.name};
  return {};
}

std::string json_list(const std::vector<std::string>& texts) {
  return fmt::format("[{}]", fmt::join(texts, ","));
}

}  // namespace tonus::dashboard
