#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "services/core/id.hpp"
#include "services/core/result.hpp"
#include "services/scheduler/journal.hpp"

namespace tonus::scheduler {

/// The journals of one scheduler: <id>.journal while a session lasts, <id>.finished afterwards. One scheduler
/// at a time has the folder.
class SessionFolder {
 public:
  /// Makes the folder if it is missing. kUnavailable: another scheduler has it.
  [[nodiscard]] static Result<SessionFolder> open(const std::filesystem::path& folder, std::string contract);

  /// The journal that has not been put away, if there is one. kDataLoss where it is damaged or there are two:
  /// nothing is guessed.
  [[nodiscard]] Result<std::optional<Journal::Opened>> reopen();

  [[nodiscard]] Result<Journal> begin(const Id& session) const;
  /// Puts a journal away: the session has ended, and everybody was told.
  [[nodiscard]] Result<void> finish(const Id& session) const;
  /// True if there is or has been such a session.
  [[nodiscard]] bool knows(const Id& session) const;

 private:
  SessionFolder(std::filesystem::path folder, std::string contract, std::unique_ptr<FileStorage> lock)
      : folder_(std::move(folder)), contract_(std::move(contract)), lock_(std::move(lock)) {}
  [[nodiscard]] std::filesystem::path file_of(const Id& session, const char* extension) const;

  std::filesystem::path folder_;
  std::string contract_;
  std::unique_ptr<FileStorage> lock_;
};

}  // namespace tonus::scheduler
