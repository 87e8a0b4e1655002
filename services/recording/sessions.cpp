#include "services/recording/sessions.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "services/core/folder.hpp"
#include "services/core/json_text.hpp"
#include "services/core/text.hpp"
#include "services/core/text_file.hpp"
#include "services/recording/table.hpp"

namespace tonus::recording {
namespace {

namespace fs = std::filesystem;
using Sessions = std::map<std::string, SessionFacts>;

std::string cell(const std::string& text) {
  if (text.empty()) return "n/a";
  return shown(text);
}

std::string sessions_text(const Sessions& sessions) {
  std::string text = "session_id\tacq_time\toperator\tstudy\tpilot\n";
  for (const auto& [session, facts] : sessions) {
    text += session + '\t' + cell(facts.started_at) + '\t' + cell(facts.operator_name) + '\t' +
            cell(facts.study) + '\t' + (facts.is_pilot ? "true" : "false") + '\n';
  }
  return text;
}

std::string sessions_json() {
  nlohmann::ordered_json json;
  json["acq_time"]["Description"] = "When the session began, UTC";
  json["operator"]["Description"] = "Who ran the session";
  json["study"]["Description"] = "Study that the session belongs to";
  json["pilot"]["Description"] = "Whether the session is a rehearsal, and no part of a study's results";
  json["pilot"]["Levels"] = {{"true", "a rehearsal"}, {"false", "not a rehearsal"}};
  return json_text(json, 2) + "\n";
}

}  // namespace

fs::path sessions_file(const fs::path& root, const std::string& participant) {
  return root / participant / (participant + "_sessions.tsv");
}

Result<Sessions> read_sessions(const fs::path& file) {
  TONUS_TRY_ASSIGN(const bool has_file, is_present(file));
  if (!has_file) return Sessions();
  TONUS_TRY_ASSIGN(const auto table, Table::read(file));
  TONUS_TRY(table.require({"session_id"}));
  Sessions sessions;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    SessionFacts facts;
    facts.started_at = table.text(row, "acq_time");
    facts.operator_name = table.text(row, "operator");
    facts.study = table.text(row, "study");
    const std::string pilot = table.text(row, "pilot");
    if (!pilot.empty() && pilot != "true" && pilot != "false")
      return table.refuse(row, "pilot", "true, false or n/a");
    facts.is_pilot = pilot == "true";
    sessions[std::string(table.cell(row, "session_id"))] = facts;
  }
  return sessions;
}

Result<void> write_sessions(const fs::path& root, const std::vector<Recording>& recordings) {
  std::map<std::string, Sessions> participants;
  for (const Recording& recording : recordings) {
    if (!recording.session.empty())
      participants[recording.participant.id][recording.session] = recording.session_facts;
  }
  for (const auto& [participant, sessions] : participants) {
    const bool is_known =
        std::ranges::any_of(sessions, [](const auto& session) { return session.second != SessionFacts(); });
    if (!is_known) continue;
    const fs::path file = sessions_file(root, participant);
    TONUS_TRY(create_text_file(file, sessions_text(sessions)));
    TONUS_TRY(create_text_file(fs::path(file).replace_extension(".json"), sessions_json()));
  }
  return {};
}

}  // namespace tonus::recording
