#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

/// The channels of a rig beside force and motion, free of wire types.
namespace tonus {

/// A signal as the rig describes it: EMG, grip force, a trigger, an eye's or a heart's.
struct AuxiliaryChannel {
  std::string name;
  std::string type;                     ///< Of BIDS: EMG, MISC, TRIG, ...
  std::string unit;                     ///< Of value * unit_per_value.
  double unit_per_value = 1.0;          ///< Not 0.
  std::uint32_t values_per_sample = 1;  ///< Rate over the rig's sample rate.

  [[nodiscard]] bool is_emg() const { return type == "EMG"; }
  bool operator==(const AuxiliaryChannel&) const = default;
};

/// What a channel gave during a run of samples, on its own time axis: value k was measured
/// k / rate after the run's first sample. Value j of sample i is number i * values_per_sample + j.
struct AuxiliarySeries {
  AuxiliaryChannel channel;
  double rate = 0.0;          ///< Hz, the channel's own.
  std::vector<float> values;  ///< In the channel's unit; not finite: not measured, or not there.
};

/// Values of all channels with each sample.
[[nodiscard]] inline std::uint32_t values_per_sample(std::span<const AuxiliaryChannel> channels) {
  std::uint32_t values = 0;
  for (const AuxiliaryChannel& channel : channels) values += channel.values_per_sample;
  return values;
}

}  // namespace tonus
