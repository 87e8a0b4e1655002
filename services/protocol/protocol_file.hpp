#pragma once

#include <filesystem>
#include <string>

#include "services/protocol/protocol.hpp"

namespace tonus::protocol {

/// Reads and checks a protocol file. kNotFound or kIo where it cannot be read, else as parse_protocol. Of a
/// study the files that it names are read and checked too, and must be of the kind that their key says.
[[nodiscard]] Result<Protocol> load_protocol(const std::filesystem::path& file);

}  // namespace tonus::protocol
