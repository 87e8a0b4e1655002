#include "rig_agent/control/auxiliary_collector.hpp"

#include <algorithm>
#include <limits>

namespace tonus::control {
namespace {

constexpr float kNotMeasured = std::numeric_limits<float>::quiet_NaN();

}  // namespace

AuxiliaryCollector::AuxiliaryCollector(std::span<const AuxiliaryChannel> channels, double sample_rate,
                                       unsigned divider)
    : divider_(divider) {
  std::size_t first = 0;
  for (const auto& channel : channels) {
    const std::uint32_t values = values_per_sample(channel, sample_rate);
    channels_.push_back({first, values});
    first += values;
  }
  counts_.resize(channels_.size());
  given_.resize(first);
  row_.assign(first, kNotMeasured);
}

void AuxiliaryCollector::begin_sample() noexcept { std::fill(row_.begin(), row_.end(), kNotMeasured); }

// Values of a channel that are due before this cycle of a sample.
std::uint32_t AuxiliaryCollector::place(const Channel& channel, unsigned cycle) const noexcept {
  return static_cast<std::uint32_t>(std::uint64_t{channel.values} * cycle / divider_);
}

void AuxiliaryCollector::collect(drivers::Driver& driver, std::uint64_t cycle, bool is_timely) noexcept {
  const auto own = static_cast<unsigned>((cycle + divider_ - 1) % divider_);
  std::size_t due = 0;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    counts_[i] = place(channels_[i], own + 1) - place(channels_[i], own);
    due += counts_[i];
  }
  if (due == 0) return;
  const std::span<float> given(given_.data(), due);
  std::fill(given.begin(), given.end(), kNotMeasured);
  driver.read_auxiliary(counts_, given);
  if (!is_timely) return;
  std::size_t next = 0;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    std::copy_n(given.begin() + static_cast<std::ptrdiff_t>(next), counts_[i],
                row_.begin() + static_cast<std::ptrdiff_t>(channels_[i].first + place(channels_[i], own)));
    next += counts_[i];
  }
}

}  // namespace tonus::control
