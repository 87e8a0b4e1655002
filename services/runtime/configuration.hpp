#pragma once

#include <string>

namespace CLI {
class App;
}  // namespace CLI

namespace tonus::runtime {

/// Every option of a parsed command line with the value in force, defaults included, as TOML. Passwords in
/// URLs are left out: the text is published and archived.
[[nodiscard]] std::string configuration_text(const CLI::App& app);

/// Compiler, kind of build, system and libraries.
[[nodiscard]] std::string build_text();

}  // namespace tonus::runtime
