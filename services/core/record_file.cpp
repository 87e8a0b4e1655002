#include "services/core/record_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "services/core/crc32c.hpp"

namespace tonus {
namespace {

struct Header {
  std::uint32_t length;
  std::uint32_t crc;
};
static_assert(sizeof(Header) == 8);

std::uint32_t checksum(std::span<const std::byte> content) {
  // The length takes part: a run of zeros is not a good record of length zero.
  return crc32c(content) ^ static_cast<std::uint32_t>(content.size() * 2654435761U + 1U);
}

bool read_exactly(int descriptor, std::byte* out, std::size_t count, std::uint64_t offset) {
  while (count > 0) {
    const ssize_t n = pread(descriptor, out, count, static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    out += n;
    offset += static_cast<std::uint64_t>(n);
    count -= static_cast<std::size_t>(n);
  }
  return true;
}

bool write_exactly(int descriptor, const std::byte* data, std::size_t count, std::uint64_t offset) {
  while (count > 0) {
    const ssize_t n = pwrite(descriptor, data, count, static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    data += n;
    offset += static_cast<std::uint64_t>(n);
    count -= static_cast<std::size_t>(n);
  }
  return true;
}

bool read_record(int descriptor, std::uint64_t offset, std::vector<std::byte>& content) {
  Header header{};
  if (!read_exactly(descriptor, reinterpret_cast<std::byte*>(&header), sizeof header, offset)) return false;
  if (header.length > RecordFile::kMaxRecord) return false;
  content.resize(header.length);
  return read_exactly(descriptor, content.data(), content.size(), offset + sizeof header) &&
         checksum(content) == header.crc;
}

Header header_at(std::span<const std::byte> bytes) {
  Header header{};
  std::memcpy(&header, bytes.data(), sizeof header);
  return header;
}

bool starts_with_record(std::span<const std::byte> bytes) {
  if (bytes.size() < sizeof(Header)) return false;
  const Header header = header_at(bytes);
  if (header.length > RecordFile::kMaxRecord || header.length > bytes.size() - sizeof header) return false;
  return checksum(bytes.subspan(sizeof header, header.length)) == header.crc;
}

/// Bytes up to the next good record, or all of them.
std::size_t bytes_before_record(std::span<const std::byte> bytes) {
  std::size_t count = 1;
  while (count < bytes.size() && !starts_with_record(bytes.subspan(count))) ++count;
  return count;
}

/// Whether bytes that no record follows are what an interrupted write leaves.
bool is_torn(std::span<const std::byte> bytes) {
  if (bytes.size() < sizeof(Header)) return true;
  if (std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; })) return true;
  const Header header = header_at(bytes);
  return header.length <= RecordFile::kMaxRecord && header.length > bytes.size() - sizeof header;
}

}  // namespace

Result<RecordFile> RecordFile::open(const std::filesystem::path& path, const Visitor& visit) {
  RecordFile file(path, FileDescriptor(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)));
  if (!file.descriptor_.is_open()) return file.system_error("cannot be opened");
  struct stat status {};
  if (fstat(file.descriptor_.get(), &status) != 0) return file.system_error("cannot be examined");
  const auto length = static_cast<std::uint64_t>(status.st_size);

  std::vector<std::byte> content;
  while (file.size_ < length) {
    if (read_record(file.descriptor_.get(), file.size_, content)) {
      if (visit) visit(file.size_, content);
      file.size_ += sizeof(Header) + content.size();
      continue;
    }
    std::vector<std::byte> rest(length - file.size_);
    if (!read_exactly(file.descriptor_.get(), rest.data(), rest.size(), file.size_))
      return file.system_error("cannot be read");
    const std::size_t bad = bytes_before_record(rest);
    if (bad == rest.size() && is_torn(rest)) break;
    file.damage_.push_back({file.size_, bad});
    file.size_ += bad;
  }
  file.torn_bytes_ = length - file.size_;
  if (file.torn_bytes_ > 0 && ftruncate(file.descriptor_.get(), static_cast<off_t>(file.size_)) != 0) {
    return file.system_error("its torn end cannot be cut off");
  }
  return file;
}

Result<std::uint64_t> RecordFile::append(std::span<const std::byte> content) {
  if (content.size() > kMaxRecord) {
    return fail(ErrorCode::kInvalidArgument, fmt::format("{}: a record of {} bytes, at most {} are allowed",
                                                         path_.string(), content.size(), kMaxRecord));
  }
  const Header header{static_cast<std::uint32_t>(content.size()), checksum(content)};
  std::vector<std::byte> record(sizeof header + content.size());
  std::memcpy(record.data(), &header, sizeof header);
  if (!content.empty()) std::memcpy(record.data() + sizeof header, content.data(), content.size());
  if (!write_exactly(descriptor_.get(), record.data(), record.size(), size_)) {
    const Error error = system_error("cannot be written");
    if (ftruncate(descriptor_.get(), static_cast<off_t>(size_)) != 0)
      return system_error("cannot be written or mended");
    return error;
  }
  return std::exchange(size_, size_ + record.size());
}

Result<std::vector<std::byte>> RecordFile::read(std::uint64_t offset) const {
  std::vector<std::byte> content;
  if (!read_record(descriptor_.get(), offset, content)) {
    return fail(ErrorCode::kDataLoss,
                fmt::format("{}: the record at byte {} is damaged", path_.string(), offset));
  }
  return content;
}

std::string RecordFile::damage_text() const {
  if (damage_.empty()) return {};
  std::uint64_t bytes = 0;
  for (const DamagedBytes& run : damage_) bytes += run.count;
  return fmt::format(
      "{}: {} bytes in {} place{} are damaged, the first at byte {}: the records there are lost",
      path_.string(), bytes, damage_.size(), damage_.size() == 1 ? "" : "s", damage_.front().offset);
}

Result<void> RecordFile::rename_to(const std::filesystem::path& path) {
  if (std::rename(path_.c_str(), path.c_str()) != 0) return system_error("cannot be renamed");
  path_ = path;
  return {};
}

Result<void> RecordFile::sync() {
  if (fdatasync(descriptor_.get()) != 0) return system_error("cannot be synced");
  return {};
}

Error RecordFile::system_error(const char* what) const {
  return fail(ErrorCode::kIo, fmt::format("{}: {}: {}", path_.string(), what, std::strerror(errno)));
}

}  // namespace tonus
