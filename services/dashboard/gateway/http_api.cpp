#include "services/dashboard/gateway/http_api.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/contract/message_json.hpp"
#include "services/contract/names.hpp"
#include "services/core/clock.hpp"
#include "services/core/folder.hpp"
#include "services/core/text_file.hpp"
#include "services/dashboard/gateway/json_messages.hpp"
#include "services/dashboard/gateway/pages.hpp"
#include "services/dashboard/gateway/people_api.hpp"
#include "services/dashboard/gateway/trial_course.hpp"
#include "services/store/open_store.hpp"
#include "services/store/session_list.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::dashboard {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::size_t kMaximumListed = 1000;
constexpr std::uintmax_t kMaximumReportBytes = std::uintmax_t{64} << 20;

ApiAnswer as_json(const json& value) {
  return {200, "application/json", value.dump(-1, ' ', false, json::error_handler_t::replace)};
}

ApiAnswer refusal(int status, const std::string& why) {
  auto answer = as_json({{"error", why}});
  answer.status = status;
  return answer;
}

ApiAnswer refusal(const Error& error) {
  return refusal(error.code == ErrorCode::kNotFound || error.code == ErrorCode::kInvalidArgument ? 404 : 503,
                 error.message);
}

ApiAnswer protocols(const fs::path& folder) {
  json list = json::array();
  const auto files = list_folder(folder);
  if (!files && files.error().code != ErrorCode::kNotFound) return refusal(files.error());
  for (const auto& file : files ? *files : std::vector<fs::path>()) {
    if (file.extension() != ".toml") continue;
    const auto text = read_text_file(file);
    if (text) {
      list.push_back({{"name", file.stem().string()}, {"text", *text}});
    } else {
      spdlog::warn("protocols: {}", text.error().message);
    }
  }
  return as_json(list);
}

json to_json(const store::Certificate& certificate) {
  return {{"expected", certificate.expected},
          {"received", certificate.received},
          {"resent", certificate.resent},
          {"duplicated", certificate.duplicated},
          {"missing", certificate.missing}};
}

json to_json(const store::SessionRecord& record) {
  return {{"session_id", to_hex(record.session)},       {"subject", record.subject},
          {"protocol", record.protocol_name},           {"seed", record.seed},
          {"planned_trials", record.planned_trials},    {"started_at", record.started_at},
          {"software_version", record.software_version}};
}

json to_json(const store::TrialRecord& trial) {
  return {{"trial_id", to_hex(trial.trial)},
          {"attempt", trial.attempt},
          {"posture", trial.posture},
          {"set", trial.set},
          {"end", trial.end},
          {"is_certified", trial.is_certified},
          {"first_sequence", trial.first_sequence},
          {"last_sequence", trial.last_sequence},
          {"certificate", to_json(trial.certificate)}};
}

ApiAnswer sessions(store::Store& store) {
  auto all = store::summarise_sessions(store);
  if (!all) return refusal(all.error());
  std::reverse(all->begin(), all->end());
  json list = json::array();
  for (const auto& summary : *all) {
    if (list.size() >= kMaximumListed) break;
    json entry = to_json(summary.record);
    entry["study"] = summary.plan.study();
    entry["is_pilot"] = summary.plan.is_pilot();
    entry["state"] = summary.state ? json(v1::phase_name(summary.state->phase())) : json(nullptr);
    entry["counted"] = summary.state ? json(summary.state->counted()) : json(nullptr);
    entry["rejected"] = summary.state ? json(summary.state->rejected()) : json(nullptr);
    list.push_back(std::move(entry));
  }
  return as_json(list);
}

/// Subjects or studies.
ApiAnswer people(const ApiFolders& folders, bool is_studies) {
  const auto store = store::open_store_for_reading(folders.store);
  if (!store) return refusal(store.error());
  const auto all = store::summarise_sessions(**store);
  if (!all) return refusal(all.error());
  return {200, "application/json", is_studies ? studies_json(*all, folders.protocols) : subjects_json(*all)};
}

/// Of what operators said of a session: of each key the newest, by arrival.
Result<std::vector<store::Message>> remarks(store::Store& store, const Id& session, std::string_view topic) {
  std::vector<store::Message> newest;
  const auto keep = [&](const store::Message& message) -> Result<void> {
    std::erase_if(newest, [&](const auto& known) { return known.key == message.key; });
    newest.push_back(message);
    return {};
  };
  TONUS_TRY(store.visit_messages({std::string(topic), session, std::nullopt}, keep));
  return newest;
}

bool is_remark(std::string_view topic) {
  return topic == topics::kTrialReview.spec.name || topic == topics::kSessionNote.spec.name;
}

void append_payload(std::string& out, std::span<const std::byte> payload) {
  const auto size = static_cast<std::uint32_t>(payload.size());
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<char>((size >> shift) & 0xffU));
  out.append(reinterpret_cast<const char*>(payload.data()), payload.size());
}

ApiAnswer remark_messages(store::Store& store, const Id& session, std::string_view topic) {
  const auto found = remarks(store, session, topic);
  if (!found) return refusal(found.error());
  ApiAnswer answer{200, "application/octet-stream", {}};
  for (const auto& message : *found) append_payload(answer.body, *message.payload);
  return answer;
}

ApiAnswer remarks_json(store::Store& store, const Id& session, std::string_view topic) {
  const auto found = remarks(store, session, topic);
  if (!found) return refusal(found.error());
  std::vector<std::string> texts;
  for (const auto& message : *found)
    if (auto text = json_message(topic, message.received_ns, *message.payload))
      texts.push_back(*std::move(text));
  return {200, "application/json", json_list(texts)};
}

ApiAnswer session_summary(store::Store& store, const store::SessionRecord& record) {
  const auto trials = store.trials(record.session);
  if (!trials) return refusal(trials.error());
  json answer = to_json(record);
  answer["trials"] = json::array();
  store::Certificate sum;
  for (const auto& trial : *trials) {
    answer["trials"].push_back(to_json(trial));
    sum += trial.certificate;
  }
  answer["certificate"] = to_json(sum);
  return as_json(answer);
}

template <typename T>
void append(std::string& out, const T& value) {
  const auto payload = bus::encode(value);
  if (!payload) return;  // it has been decoded from a message: it is within its bounds
  append_payload(out, *payload);
}

ApiAnswer session_messages(store::Store& store, const Id& id, std::string_view topic) {
  if (is_remark(topic)) return remark_messages(store, id, topic);
  const auto session = store::read_session(store, id);
  if (!session) return refusal(session.error());
  ApiAnswer answer{200, "application/octet-stream", {}};
  if (topic == "session/plan") {
    append(answer.body, session->plan);
  } else if (topic == "session/state") {
    if (session->state) append(answer.body, *session->state);
  } else if (topic == "estimate/condition") {
    for (const auto& estimate : store::newest_estimates(*session)) append(answer.body, estimate);
  } else if (topic == "estimate/history") {
    for (const auto& estimate : session->estimates) append(answer.body, estimate.value);
  } else if (topic == "trial/outcome") {
    for (const auto& trial : session->trials)
      if (trial.outcome) append(answer.body, trial.outcome->value);
  } else if (topic == "trial/verdict") {
    for (const auto& trial : session->trials)
      if (trial.verdict) append(answer.body, trial.verdict->value);
  } else if (topic == "rig/description") {
    for (const auto& description : session->descriptions) append(answer.body, description.value);
  } else {
    return refusal(404, fmt::format("topic '{:.80}' is not given out", topic));
  }
  return answer;
}

/// Messages of a session as the live paths of the same names give them.
std::optional<ApiAnswer> session_json(store::Store& store, const Id& id, std::string_view what) {
  if (what == "/reviews") return remarks_json(store, id, topics::kTrialReview.spec.name);
  if (what == "/notes") return remarks_json(store, id, topics::kSessionNote.spec.name);
  constexpr std::array<std::string_view, 4> kKnown{"/estimates", "/outcomes", "/plans", "/verdicts"};
  if (std::find(kKnown.begin(), kKnown.end(), what) == kKnown.end()) return std::nullopt;
  const auto session = store::read_session(store, id);
  if (!session) return refusal(session.error());
  std::vector<std::string> texts;
  const auto add = [&](const auto& topic, const auto& value, std::uint64_t time_ns) {
    texts.push_back(json_text_of(topic.spec.name, time_ns, contract::message_json(value)));
  };
  if (what == "/plans") add(topics::kSessionPlan, session->plan, 0);
  if (what == "/estimates") {
    std::map<Id, std::uint64_t> published;
    for (const auto& estimate : session->estimates)
      published[estimate.value.estimate_id()] = estimate.received_ns;
    for (const auto& estimate : store::newest_estimates(*session))
      add(topics::kEstimateCondition, estimate, published[estimate.estimate_id()]);
  }
  for (const auto& trial : session->trials) {
    if (what == "/verdicts" && trial.verdict)
      add(topics::kTrialVerdict, trial.verdict->value, trial.verdict->received_ns);
    if (what == "/outcomes" && trial.outcome)
      add(topics::kTrialOutcome, trial.outcome->value, trial.outcome->received_ns);
  }
  return ApiAnswer{200, "application/json", json_list(texts)};
}

/// `attempt`: the rest of the path.
ApiAnswer session_courses(store::Store& store, const Id& id, std::string_view attempt) {
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(attempt.data(), attempt.data() + attempt.size(), number);
  if (error != std::errc() || end != attempt.data() + attempt.size())
    return refusal(404, fmt::format("trial '{:.20}' is not allowed; expected a number", attempt));
  const auto session = store::read_session(store, id);
  if (!session) return refusal(session.error());
  auto text = trial_courses(store, *session, number);
  if (!text) return refusal(text.error());
  return {200, "application/json", std::move(*text)};
}

ApiAnswer archived(const std::string& name, std::string_view rest, std::string_view topic) {
  const auto store = store::open_store_for_reading(name);
  if (!store) return refusal(store.error());
  if (rest.empty()) return sessions(**store);
  rest.remove_prefix(1);
  const auto slash = rest.find('/');
  const auto record = store::find_session(**store, rest.substr(0, slash));
  if (!record) return refusal(record.error());
  if (slash == std::string_view::npos) return session_summary(**store, *record);
  if (rest.substr(slash) == "/messages") return session_messages(**store, record->session, topic);
  if (auto answer = session_json(**store, record->session, rest.substr(slash))) return *std::move(answer);
  constexpr std::string_view kCourses = "/courses/";
  if (rest.substr(slash).starts_with(kCourses))
    return session_courses(**store, record->session, rest.substr(slash + kCourses.size()));
  return refusal(404, "there is no such page");
}

std::uint64_t utc_ns(fs::file_time_type time) {
  const auto system = std::chrono::file_clock::to_sys(time);
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(system.time_since_epoch()).count());
}

ApiAnswer report_list(const fs::path& folder) {
  json list = json::array();
  const FilesBelow below = files_below(folder);
  for (const Error& error : below.unreachable) {
    if (error.code != ErrorCode::kNotFound) spdlog::warn("reports: {}", error.message);
  }
  for (const FileBelow& file : below.files) {
    if (list.size() >= kMaximumListed) break;
    list.push_back(
        {{"path", file.relative}, {"bytes", file.bytes}, {"modified", iso8601(utc_ns(file.modified))}});
  }
  return as_json(list);
}

ApiAnswer report_file(const fs::path& folder, std::string_view path) {
  std::error_code error;
  const fs::path root = fs::canonical(folder, error);
  const fs::path file = fs::weakly_canonical(root / fs::path(path), error);
  const auto inside = std::mismatch(root.begin(), root.end(), file.begin(), file.end()).first == root.end();
  if (root.empty() || !inside || !fs::is_regular_file(file, error))
    return refusal(404, "there is no such report");
  auto text = read_text_file(file, kMaximumReportBytes);
  if (!text) return refusal(text.error());
  return {200, content_type(file), std::move(*text)};
}

}  // namespace

ApiAnswer answer_api(const ApiFolders& folders, std::string_view path, std::string_view topic) {
  constexpr std::string_view kSessions = "/api/sessions";
  constexpr std::string_view kReports = "/reports/";
  if (path == "/api/protocols") return protocols(folders.protocols);
  if (path == "/api/subjects") return people(folders, false);
  if (path == "/api/studies") return people(folders, true);
  if (path == "/api/reports") return report_list(folders.reports);
  if (path.starts_with(kReports)) return report_file(folders.reports, path.substr(kReports.size()));
  if (path == kSessions || path.starts_with("/api/sessions/"))
    return archived(folders.store, path.substr(kSessions.size()), topic);
  return refusal(404, "there is no such page");
}

}  // namespace tonus::dashboard
