#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "services/core/file_descriptor.hpp"
#include "services/core/result.hpp"

namespace tonus::scheduler {

/// The file below a journal, replaceable by one that fails. Errors are kIo and name the file and what the
/// system said.
class JournalStorage {
 public:
  virtual ~JournalStorage() = default;
  [[nodiscard]] virtual Result<std::string> read_all() = 0;
  /// Adds octets at the end. After an error some of them may be there.
  [[nodiscard]] virtual Result<void> append(std::string_view octets) = 0;
  /// Returns when everything appended has reached the disk.
  [[nodiscard]] virtual Result<void> sync() = 0;
  /// Cuts the file to its first `size` octets, and syncs.
  [[nodiscard]] virtual Result<void> truncate(std::size_t size) = 0;
};

/// A file of the operating system, for one writer: it is locked, and a second scheduler is refused
/// (kUnavailable).
class FileStorage final : public JournalStorage {
 public:
  enum class Mode : std::uint8_t { kCreate, kOpen };

  /// kCreate: the file must not be there (kAlreadyExists), and its entry in the folder is synced. kOpen: it
  /// must.
  [[nodiscard]] static Result<std::unique_ptr<FileStorage>> open(const std::filesystem::path& file,
                                                                 Mode mode);
  Result<std::string> read_all() override;
  Result<void> append(std::string_view octets) override;
  Result<void> sync() override;
  Result<void> truncate(std::size_t size) override;

 private:
  FileStorage(FileDescriptor descriptor, std::filesystem::path file)
      : descriptor_(std::move(descriptor)), file_(std::move(file)) {}
  [[nodiscard]] Error error(const char* action) const;

  FileDescriptor descriptor_;
  std::filesystem::path file_;
};

}  // namespace tonus::scheduler
