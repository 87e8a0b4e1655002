#pragma once

#include <string>

#include "services/core/result.hpp"

namespace tonus::cli {

/// The manual's page of formats, in Markdown: the archive's tables, JSON, CSV and HDF5. Columns and
/// attributes come from the tables that write them; the archive's from its schema.
[[nodiscard]] Result<std::string> formats_page();

}  // namespace tonus::cli
