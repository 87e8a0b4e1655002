#pragma once

#include <string>
#include <string_view>

#include "services/core/id.hpp"

namespace tonus {

/// Names that people give to things of a laboratory (rigs), which become parts of paths and of ids: 1 to 64
/// letters (a to z, A to Z), digits, "-" and "_", beginning with a letter or a digit. Such a name is one part
/// of a path, never a way out of a folder, an option, a hidden file, or steering for a terminal.
///
/// Returns what is wrong, "'../x' is not allowed; expected ...", fit for people; empty where nothing is.
[[nodiscard]] std::string fault_of_name(std::string_view name);

/// The id of the rig of this name, the same in every program.
[[nodiscard]] Id rig_id(const std::string& name);

}  // namespace tonus
