#include "services/cli/archive_option.hpp"

#include <CLI/CLI.hpp>

#include "services/cli/system.hpp"
#include "services/runtime/options.hpp"
#include "services/store/open_store.hpp"

namespace tonus::cli {

std::string ArchiveOption::name() const {
  if (!archive.empty()) return archive;
  return store::default_store(data.empty() ? runtime::default_data_folder() : std::filesystem::path(data))
      .string();
}

void add_archive_option(CLI::App& command, ArchiveOption& option) {
  command.add_option("--archive", option.archive,
                     "file or URL of the archive (default: archive.sqlite in the data folder)");
  runtime::add_data_option(command, option.data, "data folder");
}

Result<std::unique_ptr<store::Store>> open_to_read(const ArchiveOption& option) {
  return store::open_store_for_reading(option.name());
}

}  // namespace tonus::cli
