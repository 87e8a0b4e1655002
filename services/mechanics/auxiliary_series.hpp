#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "services/mechanics/auxiliary_channel.hpp"

namespace tonus {

/// What a channel gave during a run of samples, in its unit and on its own time axis. Value k was measured
///
///     (k - (n - 1)) / channel.rate
///
/// after the run's first sample, where n values come with a sample: the first n - 1 lie before that sample
/// (auxiliary_lead()). Value m of sample i is number i n + m.
struct AuxiliarySeries {
  AuxiliaryChannel channel;
  std::uint32_t values_per_sample = 1;  ///< n.
  std::vector<float> values;            ///< NaN: not measured, or not there.

  /// s after the run's first sample.
  [[nodiscard]] double time_of(std::size_t value) const {
    return (static_cast<double>(value) - static_cast<double>(values_per_sample - 1)) / channel.rate;
  }
};

/// A series of each channel during so many samples, nothing of it there yet. `sample_rate` in Hz, of the rig.
[[nodiscard]] inline std::vector<AuxiliarySeries> empty_series(std::span<const AuxiliaryChannel> channels,
                                                               double sample_rate, std::size_t samples) {
  std::vector<AuxiliarySeries> all;
  for (const AuxiliaryChannel& channel : channels) {
    all.push_back({channel, values_per_sample(channel, sample_rate), {}});
    all.back().values.assign(samples * all.back().values_per_sample, std::numeric_limits<float>::quiet_NaN());
  }
  return all;
}

/// Puts what the device gave with sample number `sample` of the run, all channels' values, where none is yet.
inline void put_values(std::span<const float> device, std::size_t sample, std::span<AuxiliarySeries> series) {
  std::size_t next = 0;
  for (AuxiliarySeries& one : series) {
    for (std::size_t i = 0; i < one.values_per_sample; ++i, ++next) {
      float& place = one.values[sample * one.values_per_sample + i];
      if (std::isnan(place)) place = static_cast<float>(device[next] * one.channel.unit_per_value);
    }
  }
}

}  // namespace tonus
