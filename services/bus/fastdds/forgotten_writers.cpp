#include "services/bus/fastdds/forgotten_writers.hpp"

namespace tonus::bus {
namespace {

constexpr std::size_t kFlagsAt = 1;
constexpr std::byte kFinal{0x02};
constexpr std::size_t kBaseAt = 12;  // behind the header, reader and writer
constexpr std::size_t kBitsAt = kBaseAt + 8;
constexpr std::size_t kEmptySetEnd = kBitsAt + 4;
constexpr std::size_t kWord = 4;
constexpr unsigned kMostRepetitions = 8;  // of a request; a lost answer costs one or two

BytePatch count_patch(std::size_t at, std::uint32_t count, bool is_little_endian) {
  BytePatch patch{at, {}, kWord};
  for (std::size_t i = 0; i < kWord; ++i) {
    const std::size_t place = is_little_endian ? i : kWord - 1 - i;
    patch.bytes[i] = static_cast<std::byte>(count >> (8 * place));
  }
  return patch;
}

}  // namespace

bool ForgottenWriters::note(const Acknowledgement& word, std::uint32_t& count) {
  const std::lock_guard lock(mutex_);
  if (readers_.size() >= kMostReaders && !readers_.contains(word.ends))
    readers_.clear();  // strangers filled it
  const auto [place, is_new] = readers_.try_emplace(word.ends);
  Reader& reader = place->second;
  count = word.count + reader.count_offset;
  if (!is_new && count <= reader.count) {
    reader.count_offset += reader.count + 1 - count;
    count = reader.count + 1;
  }
  reader.count = count;
  const bool is_repeated = !is_new && word.asks && word.base == reader.base;
  reader.repetitions = is_repeated ? reader.repetitions + 1 : 0;
  const bool begins_anew = word.base < reader.base || reader.repetitions >= kMostRepetitions;
  if (begins_anew) reader.repetitions = 0;
  reader.base = begins_anew ? 0 : word.base;
  return begins_anew;
}

void ForgottenWriters::see(const Acknowledgement& word, std::span<const std::byte> datagram,
                           std::vector<BytePatch>& patches) {
  std::uint32_t count = 0;
  const bool begins_anew = note(word, count);
  if (!begins_anew) {
    if (count != word.count) patches.push_back(count_patch(word.count_at, count, word.is_little_endian));
    return;
  }
  patches.push_back({word.at + kFlagsAt, {datagram[word.at + kFlagsAt] & ~kFinal}, 1});
  for (std::size_t at = kBaseAt; at < kEmptySetEnd; at += kWord) patches.push_back({word.at + at, {}, kWord});
  patches.push_back(count_patch(word.at + kEmptySetEnd, count, word.is_little_endian));
}

}  // namespace tonus::bus
