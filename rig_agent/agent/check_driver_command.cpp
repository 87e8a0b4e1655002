#include "rig_agent/agent/check_driver_command.hpp"

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <unistd.h>

#include "services/core/folder.hpp"
#include "services/core/installation.hpp"
#include "services/runtime/options.hpp"

namespace tonus::rig {

void add_check_driver_command(CLI::App& app, CheckDriverOptions& options) {
  auto* command = app.add_subcommand("check-driver",
                                     "Puts a driver library to the contract that every driver keeps. The "
                                     "device moves: nobody holds the handle.");
  command->add_option("library", options.file, "the shared library")->required()->check(CLI::ExistingFile);
  command->add_option("--driver-options", options.text, "text that is handed to it");
  runtime::set_example(*command, "tonus-rig-agent check-driver ./spring_rig.so");
}

Error check_driver(const CheckDriverOptions& options) {
  const auto program = installation().programs / "tonus-driver-contract";
  std::error_code error;
  if (!std::filesystem::exists(program, error))
    return fail(ErrorCode::kNotFound, program.string() + " is missing; the package tonus-dev has it");
  // A name without a folder would be looked for among the system's libraries.
  const auto library = absolute_path(options.file);
  if (!library) return library.error();
  execl(program.c_str(), program.c_str(), "--driver-file", library->c_str(), "--driver-options",
        options.text.c_str(), static_cast<char*>(nullptr));
  return fail(ErrorCode::kIo, program.string() + ": " + std::strerror(errno));
}

}  // namespace tonus::rig
