#pragma once

#include <memory>
#include <string>

#include "services/archive/store.hpp"

namespace tonus::archive {

/// Opens the store that a person names: the path of an SQLite file, or ":memory:" for the simulated
/// counterpart, which keeps nothing. The only place that tells one from the other. Errors as
/// SqliteStore::open(); kInvalidArgument for a URL, which this program does not know.
[[nodiscard]] Result<std::unique_ptr<Store>> open_store_for_writing(const std::string& name);
[[nodiscard]] Result<std::unique_ptr<Store>> open_store_for_reading(const std::string& name);

}  // namespace tonus::archive
