#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "services/cli/answer.hpp"
#include "services/cli/archive_option.hpp"
#include "services/cli/commands.hpp"
#include "services/contract/names.hpp"
#include "services/contract/subject_json.hpp"
#include "services/core/json_text.hpp"
#include "services/core/text.hpp"
#include "services/runtime/options.hpp"
#include "services/store/session_list.hpp"

namespace tonus::cli {
namespace {

struct ListedSession {
  store::SessionRecord record;
  std::optional<v1::SessionState> state;
  v1::SessionPlan plan;
  store::Certificate certificate;
  std::size_t attempts = 0;
  std::size_t incomplete = 0;
};

Result<std::vector<ListedSession>> list(store::Store& store) {
  TONUS_TRY_ASSIGN(auto summaries, store::summarise_sessions(store));
  std::vector<ListedSession> sessions;
  for (auto& summary : summaries) {
    ListedSession session{summary.record, std::move(summary.state), std::move(summary.plan), {}, 0, 0};
    const auto trials = store.trials(summary.record.session);
    if (!trials) return trials.error();
    session.attempts = trials->size();
    for (const auto& trial : *trials) {
      session.incomplete += trial.is_certified ? 0 : 1;
      session.certificate += trial.certificate;
    }
    sessions.push_back(std::move(session));
  }
  return sessions;
}

std::string sample_text(const ListedSession& session) {
  if (session.attempts == 0) return "no trial yet";
  if (session.incomplete == 0) return fmt::format("whole, {} samples", session.certificate.received);
  return fmt::format("{} of {} trials incomplete, {} samples missing", session.incomplete, session.attempts,
                     session.certificate.missing);
}

std::string completeness(const ListedSession& session) {
  return (session.plan.is_pilot() ? "pilot; " : "") + sample_text(session);
}

void print(const std::vector<ListedSession>& sessions) {
  // As many digits as tell the sessions apart, and 8 at least.
  std::size_t digits = 8;
  std::vector<std::string> ids;
  ids.reserve(sessions.size());
  for (const auto& session : sessions) ids.push_back(to_hex(session.record.session));
  std::sort(ids.begin(), ids.end());
  for (std::size_t i = 1; i < ids.size(); ++i) {
    while (digits < ids[i].size() && ids[i].compare(0, digits, ids[i - 1], 0, digits) == 0) ++digits;
  }
  std::printf("%-*s  %-12s %-16s %-20s %-10s %9s %8s  %s\n", static_cast<int>(digits), "session", "subject",
              "protocol", "start", "state", "counted", "rejected", "samples");
  for (const auto& session : sessions) {
    const auto& record = session.record;
    const std::uint32_t counted = session.state ? session.state->counted() : 0;
    std::printf("%s  %-12s %-16s %-20s %-10s %9s %8u  %s\n", to_hex(record.session).substr(0, digits).c_str(),
                record.subject.c_str(), record.protocol_name.c_str(), record.started_at.c_str(),
                session.state ? v1::phase_name(session.state->phase()) : "unknown",
                fmt::format("{}/{}", counted, record.planned_trials).c_str(),
                session.state ? session.state->rejected() : 0, completeness(session).c_str());
  }
}

nlohmann::json as_json(const std::vector<ListedSession>& sessions) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& session : sessions) {
    const auto& counts = session.certificate;
    list.push_back({{"session", to_hex(session.record.session)},
                    {"subject", session.record.subject},
                    {"subject_facts", contract::message_json(session.plan.subject_facts())},
                    {"operator_name", session.plan.operator_name()},
                    {"study", session.plan.study()},
                    {"is_pilot", session.plan.is_pilot()},
                    {"protocol", session.record.protocol_name},
                    {"started_at", session.record.started_at},
                    {"state", session.state ? v1::phase_name(session.state->phase()) : "unknown"},
                    {"planned", session.record.planned_trials},
                    {"attempts", session.attempts},
                    {"counted", session.state ? session.state->counted() : 0},
                    {"rejected", session.state ? session.state->rejected() : 0},
                    {"incomplete_trials", session.incomplete},
                    {"samples",
                     {{"expected", counts.expected},
                      {"received", counts.received},
                      {"resent", counts.resent},
                      {"duplicated", counts.duplicated},
                      {"missing", counts.missing}}}});
  }
  return {{"schema", 1}, {"sessions", list}};
}

}  // namespace

void add_ls_command(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand("ls", "Lists the sessions of an archive.");
  auto option = std::make_shared<ArchiveOption>();
  auto is_json = std::make_shared<bool>(false);
  add_archive_option(*command, *option);
  add_json_flag(*command, *is_json);
  command->callback([option, is_json, &chosen] {
    chosen = [option, is_json] {
      auto store = open_to_read(*option);
      if (!store) return runtime::report("tonus ls", store.error());
      const auto sessions = list(**store);
      if (!sessions) return runtime::report("tonus ls", sessions.error());
      if (*is_json) {
        std::printf("%s\n", json_text(as_json(*sessions)).c_str());
      } else if (sessions->empty()) {
        std::printf("no session in %s\n", shown((*store)->name()).c_str());
      } else {
        print(*sessions);
      }
      return 0;
    };
  });
}

}  // namespace tonus::cli
