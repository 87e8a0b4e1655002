#include "services/recording/inherited_files.hpp"

#include <algorithm>
#include <utility>

#include "services/core/folder.hpp"

namespace tonus::recording {
namespace {

namespace fs = std::filesystem;

/// "sub-01_task-hold_channels.tsv": its entity-labels, and behind the last underscore the suffix.
std::pair<std::vector<std::string>, std::string> taken_apart(std::string_view name) {
  std::vector<std::string> parts;
  for (std::size_t end = name.find('_'); end != std::string_view::npos; end = name.find('_')) {
    parts.emplace_back(name.substr(0, end));
    name.remove_prefix(end + 1);
  }
  return {std::move(parts), std::string(name)};
}

}  // namespace

Result<const std::vector<InheritedFiles::Named>*> InheritedFiles::listed(const fs::path& folder) {
  const auto known = folders_.find(folder);
  if (known != folders_.end()) return &known->second;
  TONUS_TRY_ASSIGN(const auto entries, list_folder(folder));
  std::vector<Named> files;
  for (const fs::path& entry : entries) {
    auto [parts, suffix] = taken_apart(entry.filename().string());
    files.push_back({entry, std::move(parts), std::move(suffix)});
  }
  return &folders_.emplace(folder, std::move(files)).first->second;
}

Result<std::vector<fs::path>> InheritedFiles::of(const fs::path& motion_file, std::string_view suffix) {
  const auto own = taken_apart(motion_file.filename().string()).first;
  std::vector<fs::path> folders{root_};
  for (const fs::path& part : motion_file.parent_path().lexically_relative(root_))
    folders.push_back(folders.back() / part);
  std::vector<fs::path> files;
  for (const fs::path& folder : folders) {
    TONUS_TRY_ASSIGN(const auto* all, listed(folder));
    std::vector<const Named*> here;
    for (const Named& file : *all) {
      const bool is_one = file.suffix == suffix && std::ranges::all_of(file.parts, [&](const auto& part) {
                            return std::ranges::find(own, part) != own.end();
                          });
      if (is_one) here.push_back(&file);
    }
    std::ranges::stable_sort(here, {}, [](const Named* file) { return file->parts.size(); });
    for (const Named* file : here) {
      TONUS_TRY_ASSIGN(const bool is_there, is_present(file->path));
      if (is_there) files.push_back(file->path);
    }
  }
  return files;
}

}  // namespace tonus::recording
