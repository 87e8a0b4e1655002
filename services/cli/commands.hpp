#pragma once

#include <functional>

namespace CLI {
class App;
}  // namespace CLI

/// The subcommands of `tonus`. Each adds itself with its options to the program's command line; when it was
/// chosen, `chosen` holds what runs it and returns the exit code.
namespace tonus::cli {

using Command = std::function<int()>;

void add_up_command(CLI::App& app, Command& chosen);
void add_config_command(CLI::App& app, Command& chosen);
void add_explain_command(CLI::App& app, Command& chosen);
void add_run_command(CLI::App& app, Command& chosen);
void add_demo_command(CLI::App& app, Command& chosen);
void add_discovery_server_command(CLI::App& app, Command& chosen);
void add_doctor_command(CLI::App& app, Command& chosen);
void add_status_command(CLI::App& app, Command& chosen);
void add_pki_commands(CLI::App& app, Command& chosen);  ///< init, issue, list, revoke, renew
void add_report_command(CLI::App& app, Command& chosen);
void add_identify_command(CLI::App& app, Command& chosen);
void add_certify_command(CLI::App& app, Command& chosen);
void add_ls_command(CLI::App& app, Command& chosen);
void add_show_command(CLI::App& app, Command& chosen);
void add_verify_command(CLI::App& app, Command& chosen);
void add_backup_commands(CLI::App& app, Command& chosen);  ///< backup, restore
void add_copy_commands(CLI::App& app, Command& chosen);    ///< copy, prune
void add_recover_command(CLI::App& app, Command& chosen);
void add_export_command(CLI::App& app, Command& chosen);
void add_import_command(CLI::App& app, Command& chosen);
void add_review_commands(CLI::App& app, Command& chosen);    ///< reject, note
void add_steering_commands(CLI::App& app, Command& chosen);  ///< pause, resume, abort, stop, clear-fault

}  // namespace tonus::cli
