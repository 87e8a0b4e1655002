#include "services/scheduler/journal.hpp"

#include <array>
#include <iterator>
#include <optional>
#include <spdlog/fmt/fmt.h>

namespace tonus::scheduler {
namespace {

constexpr std::string_view kMagic = "TNSJ";
constexpr std::size_t kHeader = 16;
constexpr std::uint32_t kContentMost = 1U << 20;

constexpr std::array<std::uint32_t, 256> crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t n = 0; n < 256; ++n) {
    std::uint32_t c = n;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1U) != 0 ? 0xedb88320U ^ (c >> 1) : c >> 1;
    table[n] = c;
  }
  return table;
}

void put(std::string& out, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<char>(value >> shift & 0xffU));
}

std::uint32_t get(std::string_view in) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<std::uint8_t>(in[i]);
  return value;
}

struct Frame {
  std::uint32_t number;
  std::string_view content;
  [[nodiscard]] std::size_t size() const { return kHeader + content.size(); }
};

/// The frame that `octets` begin with, if it is whole.
std::optional<Frame> frame_at(std::string_view octets) {
  if (octets.size() < kHeader || octets.substr(0, 4) != kMagic) return std::nullopt;
  const std::uint32_t length = get(octets.substr(4));
  if (length > kContentMost || octets.size() - kHeader < length) return std::nullopt;
  const std::string_view content = octets.substr(kHeader, length);
  if (crc32(content, crc32(octets.substr(8, 4))) != get(octets.substr(12))) return std::nullopt;
  return Frame{get(octets.substr(8)), content};
}

bool holds_frame(std::string_view octets) {
  for (std::size_t at = octets.find(kMagic); at != std::string_view::npos; at = octets.find(kMagic, at + 1)) {
    if (frame_at(octets.substr(at))) return true;
  }
  return false;
}

}  // namespace

std::uint32_t crc32(std::string_view octets, std::uint32_t so_far) {
  static constexpr auto kTable = crc_table();
  std::uint32_t c = ~so_far;
  for (const char octet : octets) c = kTable[(c ^ static_cast<std::uint8_t>(octet)) & 0xffU] ^ (c >> 8);
  return ~c;
}

Result<Journal> Journal::create(std::unique_ptr<JournalStorage> storage, std::string_view contract) {
  Journal journal(std::move(storage));
  if (auto good = journal.append_frame(contract); !good) return good.error();
  return journal;
}

Result<Journal::Opened> Journal::open(std::unique_ptr<JournalStorage> storage, std::string_view contract) {
  const auto octets = storage->read_all();
  if (!octets) return octets.error();
  Journal journal(std::move(storage));
  std::vector<Record> records;
  std::string_view rest = *octets;
  while (const auto frame = frame_at(rest)) {
    if (frame->number != journal.next_number_) {
      return fail(ErrorCode::kDataLoss, fmt::format("journal: frame {} is missing, {} follows",
                                                    journal.next_number_, frame->number));
    }
    if (frame->number == 0 && frame->content != contract) {
      return fail(
          ErrorCode::kInvalidArgument,
          fmt::format("journal: written with contract {}, this program has {}", frame->content, contract));
    }
    if (frame->number > 0) {
      auto more = decode_records(frame->content);
      if (!more) return more.error();
      std::move(more->begin(), more->end(), std::back_inserter(records));
    }
    ++journal.next_number_;
    rest.remove_prefix(frame->size());
  }
  if (holds_frame(rest)) {
    return fail(ErrorCode::kDataLoss,
                fmt::format("journal: damaged at byte {}", octets->size() - rest.size()));
  }
  if (!rest.empty()) {
    if (auto cut = journal.storage_->truncate(octets->size() - rest.size()); !cut) return cut.error();
  }
  if (journal.next_number_ == 0) {  // torn before anything was promised
    if (auto good = journal.append_frame(contract); !good) return good.error();
  }
  return Opened{std::move(journal), std::move(records), rest.size()};
}

Result<void> Journal::append(const std::vector<Record>& records) {
  if (records.empty()) return {};
  const auto content = encode_records(records);
  if (!content) return content.error();
  return append_frame(*content);
}

Result<void> Journal::append_frame(std::string_view content) {
  if (has_failed_)
    return fail(ErrorCode::kIo, "journal: an earlier write failed; the scheduler has to start anew");
  if (content.size() > kContentMost) {
    return fail(ErrorCode::kInvalidArgument, fmt::format("journal: {} bytes at once, at most {} are allowed",
                                                         content.size(), kContentMost));
  }
  std::string number;
  put(number, next_number_);
  std::string frame(kMagic);
  put(frame, static_cast<std::uint32_t>(content.size()));
  frame += number;
  put(frame, crc32(content, crc32(number)));
  frame += content;
  auto good = storage_->append(frame);
  if (good) good = storage_->sync();
  has_failed_ = !good;
  ++next_number_;
  return good;
}

}  // namespace tonus::scheduler
