#include "services/bus/fastdds/forgotten_writers.hpp"

#include <algorithm>

namespace tonus::bus {
namespace {

constexpr std::size_t kFlagsAt = 1;
constexpr std::byte kFinal{0x02};
constexpr std::size_t kBaseAt = 12;  // behind the header, reader and writer
constexpr std::size_t kBitsAt = kBaseAt + 8;
constexpr std::size_t kEmptySetEnd = kBitsAt + 4;
constexpr std::size_t kWord = 4;

}  // namespace

void ForgottenWriters::see(const Acknowledgement& word, std::span<const std::byte> datagram,
                           std::vector<BytePatch>& patches) {
  {
    const std::lock_guard lock(mutex_);
    if (bases_.size() >= kMostReaders && !bases_.contains(word.ends)) bases_.clear();  // strangers filled it
    std::int64_t& base = bases_.try_emplace(word.ends, 0).first->second;
    const bool is_forward = word.base >= base;
    base = is_forward ? word.base : 0;
    if (is_forward) return;
  }
  patches.push_back({word.at + kFlagsAt, {datagram[word.at + kFlagsAt] & ~kFinal}, 1});
  for (std::size_t at = kBaseAt; at < kEmptySetEnd; at += kWord) patches.push_back({word.at + at, {}, kWord});
  BytePatch count{word.at + kEmptySetEnd, {}, kWord};
  std::copy_n(datagram.begin() + static_cast<std::ptrdiff_t>(word.count_at), kWord, count.bytes.begin());
  patches.push_back(count);
}

}  // namespace tonus::bus
