#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/result.hpp"

namespace tonus::recording {

/// Which files of a dataset hold for a recording, by BIDS' principle of inheritance: those in its folder or
/// in one above it, up to the root, whose names have no entity-label that the recording's name does not have.
/// Lists each folder once.
class InheritedFiles {
 public:
  explicit InheritedFiles(std::filesystem::path root) : root_(std::move(root)) {}

  /// Of `suffix` ("channels.tsv"), from the most general to the most special. `motion_file` lies below the
  /// root. Errors: kIo for a folder or a file that cannot be reached.
  [[nodiscard]] Result<std::vector<std::filesystem::path>> of(const std::filesystem::path& motion_file,
                                                              std::string_view suffix);

 private:
  struct Named {
    std::filesystem::path path;
    std::vector<std::string> parts;  ///< Entity-labels.
    std::string suffix;              ///< With the ending.
  };

  [[nodiscard]] Result<const std::vector<Named>*> listed(const std::filesystem::path& folder);

  std::filesystem::path root_;
  std::map<std::filesystem::path, std::vector<Named>> folders_;
};

}  // namespace tonus::recording
