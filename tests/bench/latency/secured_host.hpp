#pragma once

#include <filesystem>
#include <string>

#include "services/bus/bus.hpp"
#include "services/core/result.hpp"

namespace tonus::bench {

/// An authority in `folder` and a host that has every service's identity, an operator's, and one for the bare
/// round trips, which may write their topics and read everything. The host's folder, for --security.
[[nodiscard]] Result<std::string> make_secured_host(const std::filesystem::path& folder,
                                                    const std::string& dds);

/// The round trips' own files in that host's folder.
[[nodiscard]] bus::SecurityFiles bench_files(const std::filesystem::path& host);

}  // namespace tonus::bench
