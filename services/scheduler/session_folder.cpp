#include "services/scheduler/session_folder.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <utility>
#include <vector>

namespace tonus::scheduler {
namespace {

constexpr const char* kOpen = ".journal";
constexpr const char* kFinished = ".finished";

Error in_file(const std::filesystem::path& file, const Error& error) {
  return fail(error.code, fmt::format("{}: {}", file.string(), error.message));
}

/// For one scheduler.
Result<std::unique_ptr<FileStorage>> open_file(const std::filesystem::path& file, FileStorage::Mode mode) {
  auto storage = FileStorage::open(file, mode);
  if (storage || storage.error().code != ErrorCode::kUnavailable) return storage;
  return fail(ErrorCode::kUnavailable, fmt::format("{}: another scheduler has it open", file.string()));
}

}  // namespace

Result<SessionFolder> SessionFolder::open(const std::filesystem::path& folder, std::string contract) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return fail(ErrorCode::kIo, fmt::format("{}: cannot be made: {}", folder.string(), error.message()));
  const auto file = folder / "lock";
  auto lock = open_file(file, FileStorage::Mode::kCreate);
  if (!lock && lock.error().code == ErrorCode::kAlreadyExists)
    lock = open_file(file, FileStorage::Mode::kOpen);
  if (!lock) return lock.error();
  return SessionFolder(folder, std::move(contract), std::move(*lock));
}

std::filesystem::path SessionFolder::file_of(const Id& session, const char* extension) const {
  return folder_ / (to_hex(session) + extension);
}

Result<std::optional<Journal::Opened>> SessionFolder::reopen() {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder_, error)) {
    if (entry.path().extension() == kOpen) files.push_back(entry.path());
  }
  if (error)
    return fail(ErrorCode::kIo, fmt::format("{}: cannot be read: {}", folder_.string(), error.message()));
  std::sort(files.begin(), files.end());

  std::optional<Journal::Opened> found;
  std::filesystem::path found_file;
  for (const auto& file : files) {
    auto storage = open_file(file, FileStorage::Mode::kOpen);
    if (!storage) return storage.error();
    auto opened = Journal::open(std::move(*storage), contract_);
    if (!opened) return in_file(file, opened.error());
    if (opened->records.empty()) {  // nothing was promised in it
      if (!std::filesystem::remove(file, error)) return in_file(file, fail(ErrorCode::kIo, error.message()));
      continue;
    }
    if (found) {
      return fail(
          ErrorCode::kDataLoss,
          fmt::format("{} and {}: two unfinished sessions are not allowed; expected one; move one file away",
                      found_file.string(), file.string()));
    }
    found = std::move(*opened);
    found_file = file;
  }
  return found;
}

Result<Journal> SessionFolder::begin(const Id& session) const {
  auto storage = open_file(file_of(session, kOpen), FileStorage::Mode::kCreate);
  if (!storage) return storage.error();
  return Journal::create(std::move(*storage), contract_);
}

Result<void> SessionFolder::finish(const Id& session) const {
  std::error_code error;
  std::filesystem::rename(file_of(session, kOpen), file_of(session, kFinished), error);
  if (!error) return {};
  return fail(ErrorCode::kIo,
              fmt::format("{}: cannot be put away: {}", file_of(session, kOpen).string(), error.message()));
}

bool SessionFolder::knows(const Id& session) const {
  std::error_code error;
  return std::filesystem::exists(file_of(session, kOpen), error) ||
         std::filesystem::exists(file_of(session, kFinished), error);
}

}  // namespace tonus::scheduler
