#pragma once

#include <filesystem>
#include <string>

#include "services/core/result.hpp"

/// Where data are kept unless an option says otherwise. They cannot be made again: no place is under a folder
/// that everybody may write to, such as /tmp, and none is guessed. kUnavailable names the remedy.
namespace tonus {

/// The data folder: of a system service the first of STATE_DIRECTORY (systemd sets it to /var/lib/tonus),
/// else XDG_DATA_HOME/tonus, else HOME/.local/share/tonus. It is not made.
[[nodiscard]] Result<std::filesystem::path> default_data_folder();

/// The folder of a rig that moves something real, for what belongs to the rig and not to an experiment: its
/// calibration and its hold. /var/lib/tonus/rigs/<rig> where /var/lib/tonus exists, so that it is the same
/// one for all users of the machine, else rigs/<rig> in the default data folder. It is not made.
[[nodiscard]] Result<std::filesystem::path> default_rig_folder(const std::string& rig);

/// Whether the name of an archive is a URL, that is, of a database on a server, and not a path.
[[nodiscard]] bool is_url(const std::string& name);

}  // namespace tonus
