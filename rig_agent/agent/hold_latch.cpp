#include "rig_agent/agent/hold_latch.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <optional>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "rig_agent/agent/hold_reason.hpp"
#include "services/core/crc32c.hpp"

namespace tonus::rig {
namespace {

constexpr std::size_t kTextBytes = 448;
constexpr std::array<char, 8> kMagic{'T', 'N', 'S', 'H', 'O', 'L', 'D', '1'};
constexpr off_t kSlotDistance = 4096;  // apart by a page: one torn write meets one slot

/// One slot as it lies in the file, little endian.
struct Slot {
  std::array<char, 8> magic = kMagic;
  std::uint64_t version = 0;
  std::uint32_t number = 0;
  std::uint32_t is_powered = 0;
  std::array<char, kTextBytes> because{};  // ends with a zero; empty: not held
  std::uint32_t may_clear_unattended = 0;
  std::uint32_t checksum = 0;  // CRC-32C of all before it
};
static_assert(sizeof(Slot) == 480);

std::uint32_t checksum_of(const Slot& slot) {
  return crc32c(std::as_bytes(std::span(&slot, 1)).first(offsetof(Slot, checksum)));
}

std::optional<Slot> read_slot(int file, off_t offset) {
  Slot slot;
  if (::pread(file, &slot, sizeof(slot), offset) != static_cast<ssize_t>(sizeof(slot))) return std::nullopt;
  const bool is_good = slot.magic == kMagic && slot.checksum == checksum_of(slot) && slot.because.back() == 0;
  return is_good ? std::optional(slot) : std::nullopt;
}

Error io_error(const std::filesystem::path& path, const char* what) {
  return fail(ErrorCode::kIo,
              fmt::format("{}: {}: {}", path.string(), what, std::generic_category().message(errno)));
}

}  // namespace

Result<HoldLatch> HoldLatch::open(const std::filesystem::path& path) {
  FileDescriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0640));
  if (!file.is_open()) return io_error(path, "cannot be opened");
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) return io_error(path, "cannot be read");
  HoldLatch latch(path, std::move(file));
  if (status.st_size > 0) {
    latch.load();
    return latch;
  }
  // Both slots, so that later writes need no room.
  for (int i = 0; i < 2; ++i) TONUS_TRY(latch.write());
  return latch;
}

void HoldLatch::load() {
  const auto first = read_slot(file_.get(), 0);
  const auto second = read_slot(file_.get(), kSlotDistance);
  if (!first && !second) {
    number_ = 1;
    because_ = path_.string() + " cannot be read: " + phrase_of(HoldReason::kLatchUnreadable);
    needs_operator_ = true;
    return;
  }
  const Slot& newest = !second || (first && first->version > second->version) ? *first : *second;
  version_ = newest.version;
  number_ = newest.number;
  because_ = newest.because.data();
  needs_operator_ = is_held() && newest.may_clear_unattended == 0;
  is_powered_ = newest.is_powered != 0;
  if (!is_powered_) return;
  is_powered_ = false;
  (void)hold(phrase_of(HoldReason::kEndedUnderPower), false);  // held in memory in any case
}

Result<void> HoldLatch::hold(const std::string& because, bool needs_operator) {
  std::string text = because_.empty() ? because : because_;
  if (text.find(because) == std::string::npos) text += "; " + because;
  if (text.size() >= kTextBytes) text.resize(kTextBytes - 1);
  const bool is_news = text != because_ || (needs_operator && !needs_operator_);
  if (!is_held()) ++number_;
  because_ = std::move(text);
  needs_operator_ = needs_operator_ || needs_operator;
  if (is_on_disk_ && !is_news) return {};
  return write();
}

Result<void> HoldLatch::clear(std::uint32_t number) {
  if (number != this->number()) {
    return fail(ErrorCode::kInvalidArgument,
                is_held() ? fmt::format("hold {} is in force ({}), not {}", number_, because_, number)
                          : fmt::format("hold {} is not in force: the rig is not held", number));
  }
  const std::string because = std::exchange(because_, "");
  const bool needed_operator = std::exchange(needs_operator_, false);
  auto written = write();
  if (!written) {
    because_ = because;
    needs_operator_ = needed_operator;
  }
  return written;
}

Result<void> HoldLatch::set_powered(bool is_powered) {
  is_powered_ = is_powered;
  return write();
}

Result<void> HoldLatch::write() {
  Slot slot;
  slot.version = ++version_;
  slot.number = number_;
  slot.is_powered = is_powered_ ? 1 : 0;
  slot.may_clear_unattended = is_held() && !needs_operator_ ? 1 : 0;
  std::copy(because_.begin(), because_.end(), slot.because.begin());
  slot.checksum = checksum_of(slot);
  is_on_disk_ = false;
  const off_t offset = slot.version % 2 == 0 ? 0 : kSlotDistance;
  if (::pwrite(file_.get(), &slot, sizeof(slot), offset) != static_cast<ssize_t>(sizeof(slot)))
    return io_error(path_, "cannot be written");
  if (::fdatasync(file_.get()) != 0) return io_error(path_, "cannot be written");
  is_on_disk_ = true;
  return {};
}

}  // namespace tonus::rig
