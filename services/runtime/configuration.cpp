#include "services/runtime/configuration.hpp"

#include <CLI/CLI.hpp>

#include "services/core/passwords.hpp"
#include "services/runtime/build.hpp"

namespace tonus::runtime {

std::string configuration_text(const CLI::App& app) { return without_passwords(app.config_to_str(true)); }

std::string build_text() { return kBuild; }

}  // namespace tonus::runtime
