#include "services/cli/command_examples.hpp"

#include <CLI/CLI.hpp>
#include <sstream>
#include <string>

#include "services/runtime/options.hpp"

namespace tonus::cli {
namespace {

struct Example {
  const char* command;  ///< Below `tonus`, "" for itself.
  const char* line;
};

constexpr Example kExamples[] = {
    {"", "tonus demo deploy/protocols/unloaded.toml"},
    {"up", "tonus up --speed real --dashboard"},
    {"run", "tonus run deploy/protocols/unloaded.toml --subject s01"},
    {"demo", "tonus demo deploy/protocols/unloaded.toml --seed 7"},
    {"discovery-server", "tonus discovery-server --interface eth0"},
    {"doctor", "tonus doctor --role rig"},
    {"status", "tonus status --json"},
    {"pause", "tonus pause"},
    {"resume", "tonus resume"},
    {"abort", "tonus abort"},
    {"stop", "tonus stop --rig left"},
    {"reject", "tonus reject 6 --because coughed --by Ada"},
    {"note", "tonus note \"the subject is tired\" --trial 6"},
    {"clear-fault", "tonus clear-fault"},
    {"pki", "tonus pki init --authority lab-pki"},
    {"pki init", "tonus pki init --authority lab-pki"},
    {"pki issue", "tonus pki issue rig-host --role rig --authority lab-pki"},
    {"pki list", "tonus pki list --authority lab-pki"},
    {"pki revoke", "tonus pki revoke rig-host --authority lab-pki"},
    {"pki renew", "tonus pki renew rig-host --authority lab-pki"},
    {"identify", "tonus identify dataset --method all"},
    {"certify", "tonus certify --conditions 20 --seed 1"},
    {"report", "tonus report --cohort deploy/profiles/cohort.toml --out report"},
    {"ls", "tonus ls --json"},
    {"show", "tonus show 4f1c"},
    {"verify", "tonus verify 4f1c"},
    {"export", "tonus export 4f1c --format hdf5 --out session.h5"},
    {"import", "tonus import dataset --archive other.sqlite"},
    {"recover", "tonus recover broken.sqlite"},
    {"backup", "tonus backup archive-2026-11-28.sqlite"},
    {"copy", "tonus copy postgresql://tonus@server/lab\n  tonus copy one.sqlite --session 4f1c"},
    {"prune", "tonus prune --older-than 1825\n  tonus prune --session 4f1c --yes"},
    {"restore", "tonus restore archive-2026-11-28.sqlite"},
    {"config", "tonus config --config /etc/tonus/tonus.toml"},
    {"explain", "tonus explain off target"},
};

CLI::App* command_at(CLI::App& app, const std::string& path) {
  CLI::App* at = &app;
  std::istringstream words(path);
  for (std::string word; words >> word;) {
    const auto all = at->get_subcommands([&](CLI::App* sub) { return sub->get_name() == word; });
    if (all.empty()) return nullptr;
    at = all.front();
  }
  return at;
}

}  // namespace

void add_examples(CLI::App& app) {
  for (const auto& example : kExamples) {
    if (CLI::App* command = command_at(app, example.command)) runtime::set_example(*command, example.line);
  }
}

}  // namespace tonus::cli
