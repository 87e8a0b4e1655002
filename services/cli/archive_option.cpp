#include "services/cli/archive_option.hpp"

#include <CLI/CLI.hpp>

#include "services/core/places.hpp"
#include "services/runtime/options.hpp"
#include "services/store/open_store.hpp"

namespace tonus::cli {

Result<std::string> ArchiveOption::name() const {
  if (!archive.empty()) return archive;
  if (!data.empty()) return store::default_store(data).string();
  TONUS_TRY_ASSIGN(const auto folder, default_data_folder());
  return store::default_store(folder).string();
}

void add_archive_option(CLI::App& command, ArchiveOption& option) {
  command.add_option("--archive", option.archive,
                     "file or URL of the archive (default: archive.sqlite in the data folder)");
  runtime::add_data_option(command, option.data, "data folder");
}

Result<std::unique_ptr<store::Store>> open_to_read(const ArchiveOption& option) {
  TONUS_TRY_ASSIGN(const auto name, option.name());
  return store::open_store_for_reading(name);
}

}  // namespace tonus::cli
