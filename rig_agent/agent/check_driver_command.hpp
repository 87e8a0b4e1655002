#pragma once

#include <string>

#include "services/core/result.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace tonus::rig {

/// What `tonus-rig-agent check-driver` is told.
struct CheckDriverOptions {
  std::string file;  ///< The shared library; empty: the command was not chosen.
  std::string text;  ///< Handed to it.
};

/// Adds the command `check-driver` to the agent's command line.
void add_check_driver_command(CLI::App& app, CheckDriverOptions& options);

/// Becomes tonus-driver-contract, which puts the library to the contract that every driver keeps; its exit
/// code is 0 only where all of it holds. Returns an error where that program is not installed (kNotFound) or
/// cannot be run (kIo).
[[nodiscard]] Error check_driver(const CheckDriverOptions& options);

}  // namespace tonus::rig
