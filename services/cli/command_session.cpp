#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <spdlog/fmt/fmt.h>
#include <vector>

#include "services/cli/answer.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/condition_text.hpp"
#include "services/cli/current_session.hpp"
#include "services/contract/names.hpp"
#include "services/contract/subject.hpp"
#include "services/core/json_text.hpp"
#include "services/core/name.hpp"
#include "services/runtime/rig_stop.hpp"

namespace tonus::cli {
namespace {

constexpr std::chrono::seconds kLook{2};
constexpr std::chrono::seconds kReplyLimit{30};
constexpr std::chrono::seconds kStopLimit{5};

Error interrupted() { return fail(ErrorCode::kUnavailable, std::string(runtime::kInterruptedText)); }

constexpr std::chrono::seconds kRosterLimit{5};

/// What a system consists of.
const std::vector<v1::ServiceRole> kRoles{v1::ROLE_RIG, v1::ROLE_SCHEDULER, v1::ROLE_IDENTIFICATION,
                                          v1::ROLE_ARCHIVE};

/// What was heard. Without a scheduler nothing is known of a session.
struct Heard {
  std::vector<v1::ServiceHealth> present;
  std::vector<std::string> missing;  ///< Roles.
  bool is_session_known = false;
  std::optional<v1::SessionState> session;  ///< None: there is no session, if that is known.
  std::string held;                         ///< Why the rig is held; empty: it is not.
};

void print_status(const Heard& heard) {
  const auto& session = heard.session;
  for (const auto& health : heard.present) {
    std::printf("%-15s %-10s %-9s %s%s\n", runtime::role_name(health.role()), health.name().c_str(),
                health.is_ready() ? "ready" : "not ready", health.state().c_str(),
                health.dropped() > 0 ? fmt::format(", {} dropped", health.dropped()).c_str() : "");
    if (const std::string differs = runtime::difference(health); !differs.empty())
      std::printf("%-15s warning: %s\n", "", differs.c_str());
    for (const auto& warning : health.warnings()) std::printf("%-15s warning: %s\n", "", warning.c_str());
  }
  for (const std::string& role : heard.missing) {
    std::printf("%-15s %-10s %-9s it was not heard of within %lld s\n", role.c_str(), "", "missing",
                static_cast<long long>(kRosterLimit.count()));
  }
  if (session) {
    std::printf("session %s: %s, %u of %u trials, %u rejected", to_hex(session->session_id()).c_str(),
                phase_name(session->phase()), session->counted(), session->planned(), session->rejected());
    if (!session->waiting_for().empty()) std::printf(", waiting for: %s", session->waiting_for().c_str());
    std::printf(", %.0f s of experiment remain\n", session->remaining_s());
    for (const auto& condition : session->conditions())
      std::printf("  %s\n", condition_text(condition).c_str());
  } else if (heard.is_session_known) {
    std::printf("no session\n");
  } else {
    std::printf("session: not known without a scheduler\n");
  }
  if (!heard.held.empty()) std::printf("%s\n", heard.held.c_str());
}

/// The same for programs. No session: null.
nlohmann::json status_json(const Heard& heard) {
  const auto& session = heard.session;
  nlohmann::json json{{"schema", 1},
                      {"services", nlohmann::json::array()},
                      {"missing", heard.missing},
                      {"is_session_known", heard.is_session_known},
                      {"session", nullptr},
                      {"held", heard.held}};
  for (const auto& health : heard.present) {
    json["services"].push_back({{"role", runtime::role_name(health.role())},
                                {"name", health.name()},
                                {"host", health.host()},
                                {"is_ready", health.is_ready()},
                                {"state", health.state()},
                                {"dropped", health.dropped()},
                                {"difference", runtime::difference(health)},
                                {"warnings", health.warnings()}});
  }
  if (session) {
    json["session"] = {{"session", to_hex(session->session_id())},
                       {"phase", phase_name(session->phase())},
                       {"counted", session->counted()},
                       {"planned", session->planned()},
                       {"rejected", session->rejected()},
                       {"waiting_for", session->waiting_for()},
                       {"remaining_s", session->remaining_s()},
                       {"conditions", nlohmann::json::array()}};
    for (const auto& condition : session->conditions())
      json["session"]["conditions"].push_back(condition_json(condition));
  }
  return json;
}

Heard heard_by(SessionClient& client, const std::string& held) {
  Heard heard;
  heard.present = client.roster().present();
  for (const v1::ServiceRole role : kRoles)
    if (!client.roster().find(role)) heard.missing.emplace_back(runtime::role_name(role));
  heard.session = client.newest_state();
  heard.is_session_known = heard.session || client.roster().find(v1::ROLE_SCHEDULER);
  heard.held = held;
  return heard;
}

Result<void> status(const runtime::CommonOptions& common, bool is_json) {
  auto end = OperatorConnection::join(common);
  if (!end) return end.error();
  SessionClient& client = (*end)->client();
  const auto is_interrupted = [&end] { return (*end)->is_interrupted(); };
  const auto anybody = [&client] { return !client.roster().present().empty(); };
  const auto everybody = [&client] { return client.roster().missing(kRoles, false).empty(); };
  (void)client.wait_for(anybody, kRosterLimit, is_interrupted);
  if (is_interrupted()) return interrupted();
  if (!anybody()) {
    return fail(ErrorCode::kUnavailable, fmt::format("no service was heard of in domain {} within {} s; {}",
                                                     common.domain, kRosterLimit.count(), kServicesNotUp));
  }
  (void)client.wait_for(everybody, kRosterLimit, is_interrupted);
  (void)client.wait_for([&client] { return client.newest_state().has_value(); }, kLook, is_interrupted);
  if (is_interrupted()) return interrupted();

  const Heard heard = heard_by(client, (*end)->held());
  if (is_json) {
    std::printf("%s\n", json_text(status_json(heard)).c_str());
  } else {
    print_status(heard);
  }
  return {};
}

Result<void> stop(const runtime::CommonOptions& common, bool is_json) {
  const SystemClock clock;
  TONUS_TRY_ASSIGN(auto bus, runtime::open_bus(common, "tonus stop"));
  TONUS_TRY_ASSIGN(auto sender, runtime::RigStopSender::create(std::move(bus), clock));
  const auto took = sender.stop(rig_id(common.rig), random_id(), "command line", kStopLimit);
  if (!took) {
    return fail(took.error().code, fmt::format("{} of rig '{}' in domain {}; use the stop of the hardware",
                                               took.error().message, common.rig, common.domain));
  }
  const double took_ms = std::chrono::duration<double, std::milli>(*took).count();
  print_answer(is_json, {{"rig", common.rig}, {"after_ms", took_ms}},
               fmt::format("rig '{}' stopped after {:.1f} ms and is held. When it is safe, type: tonus "
                           "clear-fault\n",
                           common.rig, took_ms));
  return {};
}

Result<void> clear_fault(const runtime::CommonOptions& common, bool is_json) {
  TONUS_TRY_ASSIGN(const auto end, OperatorConnection::join(common));
  SessionClient& client = end->client();
  const Id rig = rig_id(common.rig);
  const auto is_interrupted = [&end] { return end->is_interrupted(); };
  if (!client.wait_for([&] { return client.rig_state(rig).has_value(); }, kLook, is_interrupted)) {
    if (is_interrupted()) return interrupted();
    return fail(ErrorCode::kNotFound, fmt::format("there is no rig '{}' in domain {}; {}", common.rig,
                                                  common.domain, kServicesNotUp));
  }
  const v1::RigState state = *client.rig_state(rig);
  if (state.mode() != v1::RIG_HELD) {
    print_answer(is_json, {{"rig", common.rig}, {"was_held", false}, {"held_because", ""}},
                 fmt::format("rig '{}' is not held\n", common.rig));
    return {};
  }
  v1::RigCommand clear;
  clear.rig_id(rig);
  clear.request(v1::RIG_CLEAR_FAULT);
  clear.hold_number(state.hold_number());
  TONUS_TRY(client.request(clear, kReplyLimit));
  print_answer(is_json, {{"rig", common.rig}, {"was_held", true}, {"held_because", state.held_because()}},
               fmt::format("rig '{}' was held: {}. It is free; a session goes on after: tonus resume\n",
                           common.rig, state.held_because()));
  return {};
}

Result<void> steer(const runtime::CommonOptions& common, bool is_json, v1::SessionRequest request) {
  TONUS_TRY_ASSIGN(const auto end, OperatorConnection::join(common));
  TONUS_TRY_ASSIGN(const auto state, current_session(*end, common));
  v1::SessionCommand command;
  command.session_id(state.session_id());
  command.request(request);
  command.subject_facts(contract::unknown_subject());
  auto reply = end->client().request(command, kReplyLimit);
  if (!reply) return reply.error();
  print_answer(is_json, {{"session", to_hex(state.session_id())}, {"message", *reply}}, *reply + "\n");
  return {};
}

void add(CLI::App& app, Command& chosen, const std::string& name, const std::string& what,
         const std::function<Result<void>(const runtime::CommonOptions&, bool is_json)>& act) {
  auto* command = app.add_subcommand(name, what);
  auto common = std::make_shared<runtime::CommonOptions>();
  auto is_json = std::make_shared<bool>(false);
  runtime::add_common_options(*command, *common);
  add_json_flag(*command, *is_json);
  command->callback([common, is_json, name, act, &chosen] {
    chosen = [common, is_json, name, act] {
      runtime::start_log("tonus " + name, *common);
      const auto outcome = act(*common, *is_json);
      return outcome ? 0 : runtime::report("tonus " + name, outcome.error());
    };
  });
}

}  // namespace

void add_status_command(CLI::App& app, Command& chosen) {
  add(app, chosen, "status", "Shows the services and the session.", status);
}

void add_steering_commands(CLI::App& app, Command& chosen) {
  add(app, chosen, "pause", "Pauses the session after the running trial.",
      [](const auto& common, bool is_json) { return steer(common, is_json, v1::SESSION_PAUSE); });
  add(app, chosen, "resume", "Goes on with a paused session, or with one that waits for the operator.",
      [](const auto& common, bool is_json) { return steer(common, is_json, v1::SESSION_RESUME); });
  add(app, chosen, "abort", "Ends the session and the running trial at once.",
      [](const auto& common, bool is_json) { return steer(common, is_json, v1::SESSION_ABORT); });
  add(app, chosen, "stop", "Stops the rig at once and holds it; needs nothing of the system but the rig.",
      stop);
  add(app, chosen, "clear-fault",
      "Frees a rig that is held by a fault, a stop or a restart; a session goes on after `resume`.",
      clear_fault);
}

}  // namespace tonus::cli
