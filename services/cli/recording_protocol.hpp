#pragma once

#include <filesystem>
#include <string>

#include "services/core/result.hpp"

namespace tonus::cli {

/// The protocol (TOML, kind "recording") that plays every record of a BIDS dataset: each perturbation by
/// itself, or the whole record where the perturbation is continuous.
[[nodiscard]] Result<std::string> recording_protocol(const std::filesystem::path& dataset);

}  // namespace tonus::cli
