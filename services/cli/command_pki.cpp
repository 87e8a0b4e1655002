#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include "services/cli/answer.hpp"
#include "services/cli/commands.hpp"
#include "services/pki/authority.hpp"
#include "services/runtime/options.hpp"

namespace tonus::cli {
namespace {

constexpr int kMostDays = 36500;

struct PkiOptions {
  std::string authority;
  std::string dds;
  std::string host;
  std::vector<std::string> roles;
  std::vector<std::string> rigs{"*"};
  std::string identity;
  int days = 0;
  bool is_json = false;
};

pki::UtcTime now() { return std::chrono::system_clock::now(); }

std::string date(pki::UtcTime time) {
  return fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::chrono::system_clock::to_time_t(time)));
}

std::string state_of(const pki::Issued& issued) {
  if (issued.is_revoked) return "revoked";
  if (issued.end <= now()) return "expired";
  return issued.is_replaced ? "replaced" : "valid";
}

Result<void> init(const PkiOptions& o) {
  TONUS_TRY_ASSIGN(const auto authority,
                   pki::Authority::create(o.authority, o.dds, std::chrono::days(o.days), now()));
  print_answer(
      o.is_json, {{"authority", authority.folder().string()}, {"dds", o.dds}, {"days", o.days}},
      fmt::format("{}: authority of a secured domain on {}, for {} days. Keep this folder apart from "
                  "the rig; its key makes certificates.\n",
                  authority.folder().string(), o.dds, o.days));
  return {};
}

Result<void> issue(const PkiOptions& o) {
  TONUS_TRY_ASSIGN(auto authority, pki::Authority::open(o.authority));
  TONUS_TRY_ASSIGN(const auto folder,
                   authority.issue({o.host, o.roles, o.rigs, std::chrono::days(o.days)}, now()));
  print_answer(
      o.is_json, {{"host", o.host}, {"folder", folder.string()}},
      fmt::format("{}: copy this folder to {} and name it there with --security\n", folder.string(), o.host));
  return {};
}

Result<void> list(const PkiOptions& o) {
  TONUS_TRY_ASSIGN(const auto authority, pki::Authority::open(o.authority));
  if (o.is_json) {
    nlohmann::json json{{"schema", 1}, {"dds", authority.dds()}, {"certificates", nlohmann::json::array()}};
    for (const auto& issued : authority.issued()) {
      json["certificates"].push_back({{"serial", issued.serial},
                                      {"host", issued.host},
                                      {"identity", issued.identity},
                                      {"rigs", issued.rigs},
                                      {"end_utc_s", std::chrono::system_clock::to_time_t(issued.end)},
                                      {"state", state_of(issued)}});
    }
    std::printf("%s\n", json.dump(2).c_str());
    return {};
  }
  std::printf("%-8s %-20s %-15s %-12s %-9s %s\n", "serial", "host", "identity", "ends (UTC)", "state",
              "rigs");
  for (const auto& issued : authority.issued()) {
    std::printf("%-8s %-20s %-15s %-12s %-9s %s\n", std::to_string(issued.serial).c_str(),
                issued.host.c_str(), issued.identity.c_str(), date(issued.end).c_str(),
                state_of(issued).c_str(), fmt::format("{}", fmt::join(issued.rigs, ",")).c_str());
  }
  return {};
}

Result<void> revoke(const PkiOptions& o) {
  TONUS_TRY_ASSIGN(auto authority, pki::Authority::open(o.authority));
  TONUS_TRY_ASSIGN(const auto count, authority.revoke(o.host, o.identity, now()));
  print_answer(o.is_json, {{"host", o.host}, {"revoked", count}},
               fmt::format("{} certificates of {} revoked. Copy {}/hosts/*/revoked.pem to every host and "
                           "restart the programs there: until then they accept it.\n",
                           count, o.host, o.authority));
  return {};
}

Result<void> renew(const PkiOptions& o) {
  TONUS_TRY_ASSIGN(auto authority, pki::Authority::open(o.authority));
  TONUS_TRY_ASSIGN(const auto count, authority.renew(o.host, std::chrono::days(o.days), now()));
  print_answer(
      o.is_json, {{"renewed", count}},
      fmt::format("{} certificates renewed. Copy {}/hosts/HOST to each host and restart the programs "
                  "there.\n",
                  count, o.authority));
  return {};
}

class PkiCommands {
 public:
  PkiCommands(CLI::App& app, Command& chosen)
      : group_(app.add_subcommand("pki", "Certificates of a secured domain: who may write and read what.")),
        chosen_(&chosen) {
    group_->require_subcommand(1);
  }

  CLI::App& add(const std::string& name, const std::string& what, Result<void> (*act)(const PkiOptions&),
                const std::shared_ptr<PkiOptions>& options) {
    CLI::App* command = group_->add_subcommand(name, what);
    command->add_option("--authority", options->authority, "folder of the authority")
        ->envname("TONUS_AUTHORITY")
        ->required();
    add_json_flag(*command, options->is_json);
    command->callback([name, act, options, chosen = chosen_] {
      *chosen = [name, act, options] {
        const auto done = act(*options);
        return done ? 0 : runtime::report("tonus pki " + name, done.error());
      };
    });
    return *command;
  }

 private:
  CLI::App* group_;
  Command* chosen_;
};

void add_days(CLI::App& command, PkiOptions& options, int fallback) {
  options.days = fallback;
  command.add_option("--days", options.days, "how long it is valid")
      ->check(CLI::Range(1, kMostDays))
      ->capture_default_str();
}

}  // namespace

void add_pki_commands(CLI::App& app, Command& chosen) {
  PkiCommands commands(app, chosen);

  auto options = std::make_shared<PkiOptions>();
  CLI::App& of_init = commands.add("init", "Makes an authority.", init, options);
  of_init
      .add_option("--dds", options->dds, "the one DDS implementation of the domain: fastdds or cyclonedds")
      ->check(CLI::IsMember({"fastdds", "cyclonedds"}))
      ->required();
  add_days(of_init, *options, 3650);

  options = std::make_shared<PkiOptions>();
  CLI::App& of_issue =
      commands.add("issue", "Gives a host keys and permissions for its roles.", issue, options);
  of_issue.add_option("host", options->host, "its name")->required();
  of_issue
      .add_option("--role", options->roles,
                  "rig, services, dashboard, operator, viewer or subject; several with commas")
      ->delimiter(',')
      ->required();
  of_issue.add_option("--rig", options->rigs, "only for these rigs, with commas (default: every rig)")
      ->delimiter(',');
  add_days(of_issue, *options, 365);

  options = std::make_shared<PkiOptions>();
  commands.add("list", "Lists what has been given out, with its end.", list, options);

  options = std::make_shared<PkiOptions>();
  CLI::App& of_revoke = commands.add("revoke", "Takes a host's certificates back.", revoke, options);
  of_revoke.add_option("host", options->host, "its name")->required();
  of_revoke.add_option("--identity", options->identity, "only this one (default: all of the host's)");

  options = std::make_shared<PkiOptions>();
  CLI::App& of_renew = commands.add("renew", "New certificates for what hosts have.", renew, options);
  of_renew.add_option("host", options->host, "its name (default: every host)");
  add_days(of_renew, *options, 365);
}

}  // namespace tonus::cli
