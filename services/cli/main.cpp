// tonus: the command line.

#include <CLI/CLI.hpp>
#include <cstdio>

#include "services/cli/command_examples.hpp"
#include "services/cli/commands.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/usage.hpp"
#include "services/runtime/version.hpp"

int main(int argc, char** argv) {
  using namespace tonus;
  runtime::begin_program();
  CLI::App app("Measures how a person's arm resists being moved.", "tonus");
  app.require_subcommand(0, 1);
  app.set_version_flag("--version", runtime::kVersion);
  cli::Command chosen;
  cli::add_up_command(app, chosen);
  cli::add_run_command(app, chosen);
  cli::add_demo_command(app, chosen);
  cli::add_discovery_server_command(app, chosen);
  cli::add_doctor_command(app, chosen);
  cli::add_status_command(app, chosen);
  cli::add_steering_commands(app, chosen);
  cli::add_review_commands(app, chosen);
  cli::add_pki_commands(app, chosen);
  cli::add_identify_command(app, chosen);
  cli::add_certify_command(app, chosen);
  cli::add_report_command(app, chosen);
  cli::add_ls_command(app, chosen);
  cli::add_show_command(app, chosen);
  cli::add_verify_command(app, chosen);
  cli::add_export_command(app, chosen);
  cli::add_import_command(app, chosen);
  cli::add_recover_command(app, chosen);
  cli::add_backup_commands(app, chosen);
  cli::add_copy_commands(app, chosen);
  cli::add_config_command(app, chosen);
  cli::add_explain_command(app, chosen);
  cli::add_examples(app);
  runtime::end_when_interrupted("tonus");
  if (const int code = runtime::parse_command_line(app, argc, argv); code >= 0) return code;
  if (!chosen) {
    std::fprintf(stderr, "tonus: command is missing; tonus --help lists them\n");
    return 2;
  }
  return runtime::end_program("tonus", chosen());
}
