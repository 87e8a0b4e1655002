#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "services/store/store.hpp"

namespace tonus::store {

/// The archive of a data folder, where a person names none: archive.sqlite.
[[nodiscard]] std::filesystem::path default_store(const std::filesystem::path& data);

/// SqliteStore::pending_upgrade(); of a server nothing is known before it is done.
[[nodiscard]] Result<std::vector<std::string>> pending_upgrade(const std::string& name);

/// Opens the store that a person names: the path of an SQLite file, the URL of a PostgreSQL database
/// (postgresql://USER@HOST/DATABASE), or ":memory:" for the simulated counterpart, which keeps nothing. The
/// only place that tells one from the other. Errors as SqliteStore::open() and PostgresStore::open();
/// kInvalidArgument for any other URL.
[[nodiscard]] Result<std::unique_ptr<Store>> open_store_for_writing(const std::string& name);
[[nodiscard]] Result<std::unique_ptr<Store>> open_store_for_reading(const std::string& name);

}  // namespace tonus::store
