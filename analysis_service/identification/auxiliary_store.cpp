#include "analysis_service/identification/auxiliary_store.hpp"

#include <algorithm>

namespace tonus::identification {
namespace {

constexpr std::size_t kMostValues = std::size_t{16} << 20U;  // 64 MB
constexpr std::size_t kTrialsRemembered = 1024;

}  // namespace

void AuxiliaryStore::add(const AuxiliaryRows& block) {
  if (block.trial == kNoId || block.rows == 0 || block.values.empty()) return;
  if (std::find(done_.begin(), done_.end(), block.trial) != done_.end()) return;
  blocks_.push_back({block.trial, block.epoch, block.range(),
                     std::vector<float>(block.values.begin(), block.values.end())});
  values_ += block.values.size();
  while (values_ > kMostValues) {
    values_ -= blocks_.front().values.size();
    blocks_.pop_front();
  }
}

std::vector<SequenceRange> AuxiliaryStore::missing(const TrialReport& report) const {
  std::vector<SequenceRange> there;
  for (const Block& block : blocks_) {
    if (block.trial == report.plan.trial && block.epoch == report.epoch) there.push_back(block.range);
  }
  std::sort(there.begin(), there.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<SequenceRange> missing;
  std::uint64_t next = report.range.first;
  for (const SequenceRange& range : there) {
    const std::uint64_t first = std::min(range.first, report.range.end);
    if (first > next) missing.push_back({next, first});
    next = std::max(next, range.end);
  }
  if (next < report.range.end) missing.push_back({next, report.range.end});
  return missing;
}

std::vector<AuxiliarySeries> AuxiliaryStore::series_of(const TrialReport& report,
                                                       std::span<const AuxiliaryChannel> channels) const {
  const std::size_t total = values_per_sample(channels, report.sample_rate);
  auto series = empty_series(channels, report.sample_rate, report.range.count());
  for (const Block& block : blocks_) {
    if (block.trial != report.plan.trial || block.epoch != report.epoch) continue;
    if (block.values.size() != total * block.range.count()) continue;
    const std::uint64_t end = std::min(block.range.end, report.range.end);
    for (std::uint64_t n = std::max(block.range.first, report.range.first); n < end; ++n) {
      put_values(std::span(block.values).subspan((n - block.range.first) * total, total),
                 n - report.range.first, series);
    }
  }
  return series;
}

void AuxiliaryStore::finish(const Id& trial) {
  for (const Block& block : blocks_) values_ -= block.trial == trial ? block.values.size() : 0;
  std::erase_if(blocks_, [&](const Block& block) { return block.trial == trial; });
  done_.push_back(trial);
  if (done_.size() > kTrialsRemembered) done_.pop_front();
}

}  // namespace tonus::identification
