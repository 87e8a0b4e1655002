#pragma once

#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace tonus::runtime {

/// What is wrong with a word of the command line that is neither a command nor an option where it stands: one
/// line that begins with the program and the commands before it, and says what was probably meant. Nothing:
/// every word is known.
[[nodiscard]] std::optional<std::string> unknown_word(const CLI::App& app,
                                                      const std::vector<std::string>& words);

/// From here on Ctrl-C and SIGTERM end the program with one line and exit code 130 or 143, unless a
/// StopSignal takes them. `program` lives as long as the program.
void end_when_interrupted(const char* program);

}  // namespace tonus::runtime
