#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "services/core/result.hpp"

namespace tonus {

/// A signal that a rig records beside force and motion: EMG, grip force, a trigger, an eye's or a heart's.
///
/// In `unit` the signal is value * unit_per_value, where a value is what the device gave (V, or a number of
/// its own). A sample of the rig, taken at time t, comes with the n = rate / sample rate values of the
/// interval that ends with it, in the order of time: value m of 0 .. n-1 was measured at
///
///     t - (n - 1 - m) / rate
///
/// so that the last one belongs to the instant of the sample itself (auxiliary_lead()). A value that is NaN
/// was not measured.
struct AuxiliaryChannel {
  std::string name;             ///< Unique in the rig; letters and digits, as a BIDS label.
  std::string type = "MISC";    ///< One of auxiliary_types().
  std::string unit = "V";       ///< Of value * unit_per_value.
  double unit_per_value = 1.0;  ///< Finite, not 0.
  double rate = 0.0;            ///< Hz, a whole multiple of the rig's sample rate.

  bool operator==(const AuxiliaryChannel&) const = default;
};

inline constexpr std::size_t kMostAuxiliaryChannels = 32;
inline constexpr double kMostAuxiliaryRate = 4000.0;  ///< Hz.
/// Of all channels together, with one sample: a block of at least three samples stays within one message.
inline constexpr std::size_t kMostAuxiliaryValues = 4096;

/// BIDS channel types that an auxiliary channel may have.
[[nodiscard]] const std::vector<std::string>& auxiliary_types();

/// What is wrong with a name, "'a b' is not allowed; expected ..."; empty where nothing is.
[[nodiscard]] std::string fault_of_auxiliary_name(const std::string& name);

/// Values of a channel with each sample; 0 where its rate is not a whole multiple of `sample_rate` (Hz).
[[nodiscard]] std::uint32_t values_per_sample(const AuxiliaryChannel& channel, double sample_rate);

/// Values of all channels with each sample.
[[nodiscard]] std::size_t values_per_sample(std::span<const AuxiliaryChannel> channels, double sample_rate);

/// s by which value `index` of the `count` with a sample is earlier than the sample; `rate` of the channel,
/// Hz.
[[nodiscard]] constexpr double auxiliary_lead(std::uint32_t index, std::uint32_t count, double rate) {
  return static_cast<double>(count - 1 - index) / rate;
}

/// kInvalidArgument with one line that names the channel, its value and what is allowed: at most 32 channels
/// of different names, known types, a unit, a scale that is not 0, and rates that are whole multiples of
/// `sample_rate` (Hz) up to 4 kHz.
[[nodiscard]] Result<void> validate(std::span<const AuxiliaryChannel> channels, double sample_rate);

}  // namespace tonus
