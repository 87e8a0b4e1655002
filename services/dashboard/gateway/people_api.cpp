#include "services/dashboard/gateway/people_api.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <spdlog/spdlog.h>

#include "services/contract/names.hpp"
#include "services/contract/subject_json.hpp"
#include "services/core/folder.hpp"
#include "services/core/id.hpp"
#include "services/core/json_text.hpp"
#include "services/protocol/protocol_file.hpp"

namespace tonus::dashboard {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct PlannedSession {
  std::string protocol;  ///< The name that its sessions bear.
  std::string file;      ///< Without extension: its name in the list of protocols.
};

std::vector<PlannedSession> planned_sessions(const protocol::StudySubject& subject, const fs::path& folder) {
  std::vector<PlannedSession> all;
  for (const std::string& file : {subject.unloaded, subject.loaded, subject.instruction}) {
    if (file.empty()) continue;
    const auto part = protocol::load_protocol(folder / file);
    if (part) all.push_back({part->name, fs::path(file).stem().string()});
  }
  return all;
}

json session_json(const store::StudySession& session) {
  return {{"protocol", session.protocol_name},
          {"session_id", to_hex(session.session)},
          {"started_at", session.started_at},
          {"state", session.phase ? json(v1::phase_name(*session.phase)) : json(nullptr)},
          {"counted", session.counted},
          {"planned", session.planned},
          {"is_pilot", session.is_pilot},
          {"is_done", session.is_done()}};
}

/// The one that is done, else the newest that is no pilot.
const store::StudySession* session_of(const store::StudySubjectProgress* progress, const std::string& name) {
  const store::StudySession* found = nullptr;
  if (progress == nullptr) return found;
  for (const auto& session : progress->sessions) {
    if (session.protocol_name != name || session.is_pilot) continue;
    if (found == nullptr || !found->is_done()) found = &session;
  }
  return found;
}

json planned_json(const PlannedSession& planned, const store::StudySession* session) {
  json object = session != nullptr ? session_json(*session)
                                   : json{{"protocol", planned.protocol},
                                          {"session_id", nullptr},
                                          {"started_at", nullptr},
                                          {"state", nullptr},
                                          {"counted", 0},
                                          {"planned", 0},
                                          {"is_pilot", false},
                                          {"is_done", false}};
  object["file"] = planned.file;
  return object;
}

const store::StudySubjectProgress* progress_of(const std::vector<store::StudySubjectProgress>& all,
                                               const std::string& subject) {
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.subject == subject; });
  return found == all.end() ? nullptr : &*found;
}

json subject_json(const protocol::StudySubject& subject, const fs::path& folder,
                  const store::StudySubjectProgress* progress) {
  json sessions = json::array();
  std::set<Id> listed;
  std::size_t done = 0;
  for (const PlannedSession& planned : planned_sessions(subject, folder)) {
    const auto* session = session_of(progress, planned.protocol);
    if (session != nullptr) listed.insert(session->session);
    done += session != nullptr && session->is_done() ? 1 : 0;
    sessions.push_back(planned_json(planned, session));
  }
  json others = json::array();
  if (progress != nullptr) {
    for (const auto& session : progress->sessions)
      if (!listed.contains(session.session)) others.push_back(session_json(session));
  }
  const std::size_t due = sessions.size() - done;
  return {{"subject", subject.name}, {"seed", subject.seed}, {"done", done}, {"due", due},
          {"sessions", sessions},    {"others", others}};
}

/// Who is next: a subject who has begun comes before one who has not.
json next_of(const json& subjects) {
  const json* next = nullptr;
  for (const json& subject : subjects) {
    if (subject["due"] == 0) continue;
    if (next == nullptr || (subject["done"] != 0 && (*next)["done"] == 0)) next = &subject;
  }
  if (next == nullptr) return nullptr;
  const auto& sessions = (*next)["sessions"];
  const auto due =
      std::find_if(sessions.begin(), sessions.end(), [](const json& one) { return one["is_done"] == false; });
  return {{"subject", (*next)["subject"]},
          {"protocol", (*due)["protocol"]},
          {"file", (*due)["file"]},
          {"seed", (*next)["seed"]}};
}

json study_json(const protocol::Protocol& study, const fs::path& file,
                const std::vector<store::SessionSummary>& sessions) {
  const auto progress = store::progress_of(sessions, study.name);
  json subjects = json::array();
  for (const auto& subject : study.subjects)
    subjects.push_back(subject_json(subject, file.parent_path(), progress_of(progress, subject.name)));
  return {{"study", study.name},
          {"file", file.stem().string()},
          {"problem", nullptr},
          {"next", next_of(subjects)},
          {"subjects", subjects}};
}

/// A study that sessions belong to and whose file is not here: what has been done in it is known.
json foreign_study_json(const std::string& name, const std::vector<store::SessionSummary>& sessions) {
  json subjects = json::array();
  for (const auto& progress : store::progress_of(sessions, name)) {
    json others = json::array();
    for (const auto& session : progress.sessions) others.push_back(session_json(session));
    subjects.push_back({{"subject", progress.subject},
                        {"seed", nullptr},
                        {"done", progress.done()},
                        {"due", nullptr},
                        {"sessions", json::array()},
                        {"others", others}});
  }
  return {{"study", name},
          {"file", nullptr},
          {"problem", "its protocol is not in the folder of the protocols: what is due is not known"},
          {"next", nullptr},
          {"subjects", subjects}};
}

}  // namespace

std::string subjects_json(const std::vector<store::SessionSummary>& sessions) {
  json all = json::array();
  for (const auto& known : store::subjects_of(sessions)) {
    all.push_back({{"subject", known.subject},
                   {"sessions", known.sessions},
                   {"pilot_sessions", known.pilot_sessions},
                   {"last_session_id", to_hex(known.last.session)},
                   {"last_started_at", known.last.started_at},
                   {"subject_facts", contract::message_json(known.facts)}});
  }
  return json_text(all, -1);
}

std::string studies_json(const std::vector<store::SessionSummary>& sessions, const fs::path& protocols) {
  json all = json::array();
  std::set<std::string> named;
  const auto files = list_folder(protocols);
  for (const auto& file : files ? *files : std::vector<fs::path>()) {
    if (file.extension() != ".toml") continue;
    const auto study = protocol::load_protocol(file);
    if (!study) {
      spdlog::warn("protocols: {}", study.error().message);
      continue;
    }
    if (study->kind != protocol::ProtocolKind::kStudy || !named.insert(study->name).second) continue;
    all.push_back(study_json(*study, file, sessions));
  }
  for (const std::string& name : store::studies_of(sessions))
    if (!named.contains(name)) all.push_back(foreign_study_json(name, sessions));
  return json_text(all, -1);
}

}  // namespace tonus::dashboard
