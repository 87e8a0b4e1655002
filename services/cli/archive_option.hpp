#pragma once

#include <memory>
#include <string>

#include "services/core/result.hpp"
#include "services/store/store.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace tonus::cli {

/// Which archive a subcommand reads or fills.
struct ArchiveOption {
  std::string archive;  ///< A file or the URL of a server; the data folder's own where empty.
  std::string data;     ///< The data folder, the default of core/places where empty.

  [[nodiscard]] Result<std::string> name() const;
};

/// Adds --archive and --data.
void add_archive_option(CLI::App& command, ArchiveOption& option);

/// A live archive may be read while its service writes it. Errors as store::open_store_for_reading().
[[nodiscard]] Result<std::unique_ptr<store::Store>> open_to_read(const ArchiveOption& option);

}  // namespace tonus::cli
