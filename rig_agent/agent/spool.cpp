#include "rig_agent/agent/spool.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <limits>
#include <optional>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <utility>

#include "services/core/folder.hpp"

namespace tonus::rig {
namespace {

constexpr char kSuffix[] = ".spool";

/// What stands before a block's messages in its record: that of the samples, and behind it that of the
/// auxiliary values. A record of an earlier version has 0 bytes of samples stated, and samples alone.
struct Prefix {
  std::uint64_t first_sequence;
  std::uint32_t count;
  std::uint32_t sample_bytes;
};
static_assert(sizeof(Prefix) == 16);

Spool::Messages messages_in(std::span<const std::byte> content) {
  Prefix prefix{};
  std::memcpy(&prefix, content.data(), sizeof prefix);
  const auto both = content.subspan(sizeof prefix);
  if (prefix.sample_bytes == 0) return {both, {}};
  return {both.first(prefix.sample_bytes), both.subspan(prefix.sample_bytes)};
}

std::optional<std::uint64_t> epoch_of(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  std::uint64_t epoch = 0;
  const auto parsed = std::from_chars(name.data(), name.data() + name.size(), epoch);
  if (parsed.ec != std::errc{} || path.extension() != kSuffix) return std::nullopt;
  return epoch;
}

std::uint64_t last_of(std::uint64_t first, std::uint64_t count) { return first + count - 1; }

/// What a record of this program can say: samples after `next`, in numbers to which can be added.
bool is_block(const Prefix& prefix, std::size_t bytes, std::uint64_t next) {
  constexpr std::uint64_t kMostFirst = std::uint64_t{1} << 62U;
  return prefix.first_sequence >= next && prefix.first_sequence <= kMostFirst && prefix.count > 0 &&
         prefix.sample_bytes <= bytes;
}

}  // namespace

Spool::Spool(SpoolOptions options) : options_(std::move(options)) {
  // A small spool must have room to free: some files of which all but the newest can go, before it is full.
  options_.retained_bytes = std::min(options_.retained_bytes, options_.max_bytes / 2);
  options_.segment_bytes = std::min(options_.segment_bytes, options_.max_bytes / 8);
}

Result<Spool> Spool::open(const SpoolOptions& options) {
  std::error_code error;
  std::filesystem::create_directories(options.folder, error);
  if (error)
    return fail(ErrorCode::kIo, fmt::format("spool {}: {}", options.folder.string(), error.message()));
  TONUS_TRY_ASSIGN(auto paths, list_folder(options.folder));  // the names are zero-padded: oldest first
  std::erase_if(paths, [](const auto& path) { return !epoch_of(path); });

  Spool spool(options);
  for (const auto& path : paths) {
    std::vector<Block> blocks;
    std::size_t foreign = 0;
    const auto take = [&](std::uint64_t offset, std::span<const std::byte> content) {
      Prefix prefix{};
      if (content.size() >= sizeof prefix) std::memcpy(&prefix, content.data(), sizeof prefix);
      const std::uint64_t next =
          blocks.empty() ? 0 : last_of(blocks.back().first_sequence, blocks.back().count) + 1;
      if (content.size() < sizeof prefix || !is_block(prefix, content.size() - sizeof prefix, next)) {
        ++foreign;
        return;
      }
      blocks.push_back({prefix.first_sequence, prefix.count, offset});
    };
    auto file = RecordFile::open(path, take);
    if (!file) return file.error();
    if (foreign > 0)
      spdlog::error("spool: {}: {} records are no blocks of samples and are left out", path.string(),
                    foreign);
    if (const std::string lost = file->damage_text(); !lost.empty()) spdlog::error("spool: {}", lost);
    spool.bytes_ += file->size();
    spool.segments_.push_back({*epoch_of(path), std::move(*file), std::move(blocks)});
  }
  return spool;
}

Result<void> Spool::append(std::uint64_t epoch, std::uint64_t first_sequence, std::uint32_t count,
                           const Messages& messages) {
  if (segments_.empty() || segments_.back().epoch != epoch ||
      segments_.back().file.size() >= options_.segment_bytes) {
    if (auto begun = begin_segment(epoch, first_sequence); !begun) return begun;
  }
  const Prefix prefix{first_sequence, count, static_cast<std::uint32_t>(messages.samples.size())};
  const auto head = std::as_bytes(std::span(&prefix, 1));
  std::vector<std::byte> record(head.begin(), head.end());
  record.insert(record.end(), messages.samples.begin(), messages.samples.end());
  record.insert(record.end(), messages.auxiliary.begin(), messages.auxiliary.end());

  Segment& segment = segments_.back();
  const std::uint64_t before = segment.file.size();
  auto offset = segment.file.append(record);
  if (!offset) return offset.error();
  segment.blocks.push_back({first_sequence, count, *offset});
  bytes_ += segment.file.size() - before;
  return {};
}

bool Spool::received(std::uint64_t epoch, std::uint64_t first, std::uint64_t through) {
  const auto last = last_sequence(epoch);
  if (!last || through > *last + 1) return false;
  const auto found = received_through_.find(epoch);
  const std::uint64_t known = found == received_through_.end() ? first_sequence(epoch) : found->second;
  if (first > known) return false;
  received_through_[epoch] = std::max(known, through);
  forget_received();
  return true;
}

std::uint64_t Spool::first_sequence(std::uint64_t epoch) const {
  for (const Segment& segment : segments_)
    if (segment.epoch == epoch && !segment.blocks.empty()) return segment.blocks.front().first_sequence;
  return 0;
}

Result<void> Spool::read(std::uint64_t epoch, std::uint64_t first, std::uint64_t last,
                         const Visitor& visit) const {
  Result<void> outcome;
  for (const auto& segment : segments_) {
    if (segment.epoch != epoch) continue;
    auto block = std::lower_bound(
        segment.blocks.begin(), segment.blocks.end(), first,
        [](const Block& b, std::uint64_t s) { return last_of(b.first_sequence, b.count) < s; });
    for (; block != segment.blocks.end() && block->first_sequence <= last; ++block) {
      auto record = segment.file.read(block->offset);
      if (record) {
        visit(messages_in(*record));
      } else {
        outcome = record.error();
      }
    }
  }
  return outcome;
}

std::vector<SpooledRange> Spool::left_behind(std::uint64_t current) const {
  std::vector<SpooledRange> ranges;
  for (const auto& segment : segments_) {
    if (segment.epoch == current || segment.blocks.empty() || is_received(segment)) continue;
    const auto known = received_through_.find(segment.epoch);
    const std::uint64_t through = known == received_through_.end() ? 0 : known->second;
    const Block& tail = segment.blocks.back();
    ranges.push_back({segment.epoch, std::max(through, segment.blocks.front().first_sequence),
                      last_of(tail.first_sequence, tail.count)});
  }
  return ranges;
}

std::optional<std::uint64_t> Spool::last_sequence(std::uint64_t epoch) const {
  for (auto segment = segments_.rbegin(); segment != segments_.rend(); ++segment) {
    if (segment->epoch != epoch || segment->blocks.empty()) continue;
    return last_of(segment->blocks.back().first_sequence, segment->blocks.back().count);
  }
  return std::nullopt;
}

Result<void> Spool::sync() {
  if (segments_.empty()) return {};
  return segments_.back().file.sync();
}

Result<void> Spool::begin_segment(std::uint64_t epoch, std::uint64_t first_sequence) {
  if (!segments_.empty()) {
    if (auto synced = segments_.back().file.sync(); !synced) return synced;
  }
  const auto path = options_.folder / fmt::format("{:020}-{:020}{}", epoch, first_sequence, kSuffix);
  auto file = RecordFile::open(path, {});
  if (!file) return file.error();
  segments_.push_back({epoch, std::move(*file), {}});
  return {};
}

bool Spool::is_received(const Segment& segment) const {
  const auto known = received_through_.find(segment.epoch);
  if (known == received_through_.end()) return false;
  return segment.blocks.empty() ||
         last_of(segment.blocks.back().first_sequence, segment.blocks.back().count) < known->second;
}

void Spool::forget_received() {
  // The newest segment is still written to.
  while (bytes_ > options_.retained_bytes && segments_.size() > 1 && is_received(segments_.front())) {
    bytes_ -= segments_.front().file.size();
    std::error_code ignored;  // A file that cannot be removed is found again at the next start.
    std::filesystem::remove(segments_.front().file.path(), ignored);
    segments_.pop_front();
  }
}

}  // namespace tonus::rig
