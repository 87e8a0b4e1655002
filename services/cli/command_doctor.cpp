#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "services/cli/answer.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/operator_connection.hpp"
#include "services/core/text.hpp"
#include "services/doctor/findings.hpp"
#include "services/doctor/host_facts.hpp"
#include "services/runtime/network.hpp"

namespace tonus::cli {
namespace {

struct DoctorOptions {
  runtime::CommonOptions common;
  std::string role = "all";
  double wait_s = 3.0;
  bool is_json = false;
};

const char* verdict_name(doctor::Verdict verdict) {
  switch (verdict) {
    case doctor::Verdict::kOk:
      return "ok";
    case doctor::Verdict::kAdvice:
      return "advice";
    case doctor::Verdict::kProblem:
      return "problem";
  }
  return "unknown";
}

doctor::ServiceFacts service_facts(const v1::ServiceHealth& health) {
  return {.role = runtime::role_name(health.role()),
          .name = health.name(),
          .host = health.host(),
          .address = runtime::address_of_host(health.host()).value_or(""),
          .is_ready = health.is_ready(),
          .state = health.state(),
          .difference = runtime::difference(health),
          .warnings = health.warnings()};
}

/// What the bus tells within the time, or sooner where all that is expected has been heard. True: Ctrl-C
/// ended it.
bool listen(const DoctorOptions& options, doctor::Facts& facts) {
  const auto end = OperatorConnection::join(options.common);
  if (!end) {
    facts.bus_problem = end.error().message;
    return false;
  }
  SessionClient& client = (*end)->client();
  const auto is_complete = [&] {
    const auto present = client.roster().present();
    return client.rig().has_value() &&
           std::all_of(facts.expected_roles.begin(), facts.expected_roles.end(),
                       [&](const std::string& role) {
                         return std::any_of(present.begin(), present.end(), [&](const auto& health) {
                           return runtime::role_name(health.role()) == role;
                         });
                       });
  };
  const auto limit = std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * options.wait_s));
  (void)client.wait_for(is_complete, limit, [&] { return (*end)->is_interrupted(); });
  if ((*end)->is_interrupted()) return true;
  for (const auto& health : client.roster().present()) facts.services.push_back(service_facts(health));
  facts.unreadable_reports = client.roster().unreadable();
  if (const auto& rig = client.rig()) {
    facts.described_rig = doctor::RigFacts{.driver = rig->driver(),
                                           .moves_nothing_real = rig->moves_nothing_real(),
                                           .watchdog_s = rig->watchdog_s(),
                                           .limits_off = rig->limits_off()};
  }
  return false;
}

void print(const std::vector<doctor::Finding>& findings, bool is_json) {
  if (is_json) {
    nlohmann::json json{{"schema", 1}, {"findings", nlohmann::json::array()}};
    for (const auto& finding : findings) {
      json["findings"].push_back({{"subject", finding.subject},
                                  {"verdict", verdict_name(finding.verdict)},
                                  {"text", shown(finding.text)},
                                  {"remedy", shown(finding.remedy)}});
    }
    std::printf("%s\n", json.dump(2).c_str());
    return;
  }
  for (const auto& finding : findings) {
    std::printf("%-8s %-12s %s\n", verdict_name(finding.verdict), finding.subject.c_str(),
                shown(finding.text).c_str());
    if (!finding.remedy.empty()) std::printf("%-21s -> %s\n", "", shown(finding.remedy).c_str());
  }
}

int examine(const DoctorOptions& options) {
  doctor::Facts facts;
  facts.is_rig_host = options.role == "rig" || options.role == "all";
  facts.expected_roles = {"rig", "scheduler", "identification", "archive"};
  doctor::find_host_facts(options.common, facts);
  if (listen(options, facts)) {
    return runtime::report("tonus doctor",
                           fail(ErrorCode::kUnavailable, std::string(runtime::kInterruptedText)));
  }
  const auto findings = doctor::judge(facts);
  print(findings, options.is_json);
  const bool has_problem = std::any_of(findings.begin(), findings.end(), [](const doctor::Finding& finding) {
    return finding.verdict == doctor::Verdict::kProblem;
  });
  return has_problem ? 1 : 0;
}

}  // namespace

void add_doctor_command(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand(
      "doctor",
      "Examines this host and what it hears; each line is ok or says what to do. Exit code 1: a problem.");
  auto options = std::make_shared<DoctorOptions>();
  runtime::add_common_options(*command, options->common);
  command->add_option("--role", options->role, "what this host is for: rig, services, desk or all")
      ->check(CLI::IsMember({"rig", "services", "desk", "all"}))
      ->capture_default_str();
  command->add_option("--wait", options->wait_s, "s to listen to the bus, at most")
      ->check(CLI::Range(0.0, 600.0))
      ->capture_default_str();
  add_json_flag(*command, options->is_json);
  command->callback([options, &chosen] {
    chosen = [options] {
      runtime::start_log("tonus doctor", options->common.log_level);
      return examine(*options);
    };
  });
}

}  // namespace tonus::cli
