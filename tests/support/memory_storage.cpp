#include "tests/support/memory_storage.hpp"

#include <algorithm>
#include <cstring>

namespace tonus::testing {

Result<void> MemoryStorage::check() const {
  if (fails_after_ == 0) return fail(ErrorCode::kIo, "memory: no space");
  return {};
}

Result<void> MemoryStorage::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  if (offset > bytes_->size() || bytes.size() > bytes_->size() - offset)
    return fail(ErrorCode::kDataLoss, "memory: fewer bytes are there");
  if (!bytes.empty()) std::memcpy(bytes.data(), bytes_->data() + offset, bytes.size());
  return {};
}

Result<void> MemoryStorage::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  const auto good = check();
  if (!good) bytes = bytes.first(std::min(torn_bytes_, bytes.size()));
  bytes_->resize(std::max<std::size_t>(bytes_->size(), offset + bytes.size()));
  if (!bytes.empty()) std::memcpy(bytes_->data() + offset, bytes.data(), bytes.size());
  return good;
}

Result<void> MemoryStorage::sync() {
  TONUS_TRY(check());
  if (fails_after_ > 0) --fails_after_;
  return {};
}

Result<void> MemoryStorage::truncate(std::uint64_t size) {
  TONUS_TRY(check());
  if (size > bytes_->size()) return fail(ErrorCode::kInvalidArgument, "memory: cut behind its end");
  bytes_->resize(size);
  return {};
}

Result<void> MemoryStorage::rename_to(const std::filesystem::path&) { return check(); }

}  // namespace tonus::testing
