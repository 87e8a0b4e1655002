#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "services/bus/bus.hpp"
#include "services/core/result.hpp"
#include "services/runtime/log.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace tonus::runtime {

/// What every program of the system is told on its command line, in its environment or in the host's file
/// (settings.hpp).
struct CommonOptions {
  int domain = 47;
  std::string dds = "fastdds";
  std::string rig = "rig";
  std::string data;  ///< Folder for what the program keeps; the default of core/places where empty.
  std::string log_level = "info";
  std::string interface;                       ///< Name or address; empty: this machine only.
  std::vector<std::string> peers;              ///< Names or addresses of the other hosts.
  std::vector<std::string> discovery_servers;  ///< ADDRESS or ADDRESS:PORT.
  std::string security;                        ///< Folder of this host's certificates; empty: no security.
  std::string configuration_file;  ///< Host's file, "none", or empty: the installed one, if it exists.
  std::string configuration;       ///< Set by parsing: all of the program's options in force, as TOML.
};

/// Adds the common options to `app`, which fills `options` when it is parsed, its configuration too.
void add_common_options(CLI::App& app, CommonOptions& options);

/// --data, of the commands that have no other common option.
CLI::Option* add_data_option(CLI::App& app, std::string& data, const std::string& what);

/// Exit codes of every program. Ctrl-C: 128 + the signal's number, as shells have it.
inline constexpr int kFailed = 1;   ///< Not done, or something is wrong; one line on standard error.
inline constexpr int kRefused = 2;  ///< The command line, the environment or a file of options; likewise.
inline constexpr int kInterrupted = 130;  ///< Ctrl-C before it was done.

/// Message of an error that means: Ctrl-C ended it.
inline constexpr std::string_view kInterruptedText = "interrupted";

/// A command that shows how it is used, at the end of --help and in the manual page.
void set_example(CLI::App& app, const std::string& command_line);

/// First line of every main(): standard descriptors that are closed are occupied, and what the program makes
/// is for its user and group alone (files 0640, folders 0750, or less where the umask says so).
void begin_program();

/// Last line of every main(): `code`, or 1 after one line on standard error where not all that was printed
/// could be written.
[[nodiscard]] int end_program(const std::string& program, int code);

/// Parses the command line; what it does not say comes from environment and files (settings.hpp). Words and
/// variables TONUS_* that are not UTF-8 are refused. Answers --print-config (the settings in force) and
/// --print-document (option_documents.hpp). Returns -1 to go on,
/// else the exit code: 0 for --help and --version, 2 for a line that was refused, after one line on standard
/// error that names the option, its value and what is allowed.
[[nodiscard]] int parse_command_line(CLI::App& app, int argc, char** argv);

/// Creates the data folder and opens the bus that the options name.
[[nodiscard]] Result<std::unique_ptr<bus::Bus>> open_bus(const CommonOptions& options,
                                                         const std::string& program);

/// The data folder, made if it is missing.
[[nodiscard]] Result<std::filesystem::path> data_folder(const CommonOptions& options);

/// One line on standard error, "program: message", as shown() has it. Returns kFailed; kInterrupted where the
/// message is kInterruptedText.
int report(const std::string& program, const Error& error);

}  // namespace tonus::runtime
