#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "services/core/file_descriptor.hpp"
#include "services/core/result.hpp"

namespace tonus {

/// The bytes below a RecordFile, replaceable by some that fail. Errors are kIo; they name the file and what
/// the operating system said.
class RecordStorage {
 public:
  virtual ~RecordStorage() = default;
  [[nodiscard]] virtual const std::filesystem::path& path() const = 0;
  [[nodiscard]] virtual Result<std::uint64_t> size() const = 0;
  /// kDataLoss: fewer bytes are there.
  [[nodiscard]] virtual Result<void> read(std::uint64_t offset, std::span<std::byte> bytes) const = 0;
  /// At the end, or over what is there from `offset` on. After an error some of them may be there.
  [[nodiscard]] virtual Result<void> write(std::uint64_t offset, std::span<const std::byte> bytes) = 0;
  /// Returns when everything written is on the disk.
  [[nodiscard]] virtual Result<void> sync() = 0;
  /// Cuts to the first `size` bytes.
  [[nodiscard]] virtual Result<void> truncate(std::uint64_t size) = 0;
  /// Takes the place of the file at `path`, in the same folder. kIo: this one keeps its name.
  [[nodiscard]] virtual Result<void> rename_to(const std::filesystem::path& path) = 0;
};

/// A file of the operating system.
class FileStorage final : public RecordStorage {
 public:
  enum class Mode : std::uint8_t {
    kCreate,        ///< It must not be there (kAlreadyExists), its folder must (kNotFound); its entry in the
                    ///< folder is synced. Locked.
    kOpen,          ///< It must be there (kNotFound). Locked.
    kOpenOrCreate,  ///< Not locked: something else sees to it that there is one writer.
  };

  /// Locked files have one writer: a second one is refused (kUnavailable). The lock ends with the process.
  [[nodiscard]] static Result<std::unique_ptr<FileStorage>> open(const std::filesystem::path& path,
                                                                 Mode mode);
  [[nodiscard]] const std::filesystem::path& path() const override { return path_; }
  [[nodiscard]] Result<std::uint64_t> size() const override;
  [[nodiscard]] Result<void> read(std::uint64_t offset, std::span<std::byte> bytes) const override;
  [[nodiscard]] Result<void> write(std::uint64_t offset, std::span<const std::byte> bytes) override;
  [[nodiscard]] Result<void> sync() override;
  [[nodiscard]] Result<void> truncate(std::uint64_t size) override;
  [[nodiscard]] Result<void> rename_to(const std::filesystem::path& path) override;

 private:
  FileStorage(FileDescriptor descriptor, std::filesystem::path path)
      : descriptor_(std::move(descriptor)), path_(std::move(path)) {}
  [[nodiscard]] Error error(const char* what) const;

  FileDescriptor descriptor_;
  std::filesystem::path path_;
};

}  // namespace tonus
