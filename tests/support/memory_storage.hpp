#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "services/core/record_storage.hpp"

namespace tonus::testing {

/// Bytes in memory below a RecordFile. After `fails_after` syncs every further change fails, and a write
/// leaves the first `torn_bytes` of its bytes.
class MemoryStorage final : public RecordStorage {
 public:
  using Bytes = std::vector<std::byte>;

  explicit MemoryStorage(std::shared_ptr<Bytes> bytes, int fails_after = -1, std::size_t torn_bytes = 0)
      : bytes_(std::move(bytes)), fails_after_(fails_after), torn_bytes_(torn_bytes) {}
  [[nodiscard]] const std::filesystem::path& path() const override { return path_; }
  [[nodiscard]] Result<std::uint64_t> size() const override { return bytes_->size(); }
  [[nodiscard]] Result<void> read(std::uint64_t offset, std::span<std::byte> bytes) const override;
  [[nodiscard]] Result<void> write(std::uint64_t offset, std::span<const std::byte> bytes) override;
  [[nodiscard]] Result<void> sync() override;
  [[nodiscard]] Result<void> truncate(std::uint64_t size) override;
  [[nodiscard]] Result<void> rename_to(const std::filesystem::path& path) override;

 private:
  [[nodiscard]] Result<void> check() const;

  const std::filesystem::path path_ = "memory";
  std::shared_ptr<Bytes> bytes_;
  int fails_after_;
  std::size_t torn_bytes_;
};

}  // namespace tonus::testing
