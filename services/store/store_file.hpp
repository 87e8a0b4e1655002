#pragma once

#include <functional>
#include <string>

#include "services/core/result.hpp"

/// New archive files. SQLite keeps up to three files beside one, which belong to it.
namespace tonus::store {

/// Makes a file that is there whole or not at all: `make` fills PARTIAL, the name with ".partial" behind it,
/// and leaves one file; it is then renamed, and its name survives a loss of power. Otherwise all of it is
/// removed. kAlreadyExists: `target` is there, also as a link to nothing, or the log of a file that is gone,
/// which SQLite would take for the new one's. kIo: it cannot be renamed. Other errors are those of `make`.
[[nodiscard]] Result<void> make_store_file(
    const std::string& target, const std::function<Result<void>(const std::string& partial)>& make);

/// Puts the file `by` in the place of `path` in one step, with its owner and permissions; the name survives a
/// loss of power. Neither is open, nor has a log. kIo: nothing is changed, and `by` is removed.
[[nodiscard]] Result<void> replace_store_file(const std::string& path, const std::string& by);

}  // namespace tonus::store
