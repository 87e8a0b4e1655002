#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "services/mechanics/auxiliary_channel.hpp"
#include "services/simulation/electromyogram.hpp"
#include "services/simulation/muscles.hpp"

namespace tonus::simulation {

/// Names of the channels that a simulated rig can have: the six muscles (EMG; `unit` V, mV or uV), and Onset
/// (TRIG), which is 1 while the digital output of the onset is high.
[[nodiscard]] std::vector<std::string> auxiliary_sources();

/// kInvalidArgument names a channel that a simulated rig cannot have, with what it can.
[[nodiscard]] Result<void> validate_auxiliary(std::span<const AuxiliaryChannel> channels);

/// What a simulated rig's auxiliary channels give: the EMG of each muscle, noise of the root mean square
/// emg_V a beside the electrode's own, a the muscle's activation. measure() is REALTIME.
class AuxiliarySignals {
 public:
  AuxiliarySignals(std::span<const AuxiliaryChannel> channels, const MuscleProfile& muscles,
                   std::uint64_t seed);

  /// For each channel in turn counts[i] values; `values` has place for all of them.
  void measure(const Activations& active, bool is_onset, std::span<const std::uint32_t> counts,
               std::span<float> values) noexcept;

 private:
  struct Source {
    double unit_per_value = 1.0;
    double volts_per_unit = 1.0;
    std::size_t muscle = 0;
    std::optional<Electromyogram> emg;  // none: the onset
  };

  const MuscleProfile muscles_;
  std::vector<Source> sources_;
};

}  // namespace tonus::simulation
