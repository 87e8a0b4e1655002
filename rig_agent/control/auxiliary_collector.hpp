#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "rig_agent/drivers/driver.hpp"
#include "services/mechanics/auxiliary_channel.hpp"

namespace tonus::control {

/// Gathers the values of the auxiliary channels over the cycles of a sample. With d cycles to a sample, of
/// which the last one takes it, and n values of a channel, cycle j of 0 .. d-1 gives the values
/// n j / d .. n (j + 1) / d - 1 (whole parts): slower than the loop, a channel has none in most cycles;
/// faster, several. Places that a cycle leaves out, or that belong to a cycle which was not run in time, stay
/// NaN. Memory is reserved by the constructor alone; the other methods are REALTIME.
class AuxiliaryCollector {
 public:
  /// The channels are validated for the sample rate (Hz) before.
  AuxiliaryCollector(std::span<const AuxiliaryChannel> channels, double sample_rate, unsigned divider);

  /// Values with a sample; 0: there are no channels, and nothing else is called.
  [[nodiscard]] std::size_t size() const noexcept { return row_.size(); }

  /// Cycle `cycle` since the start of the loop, of which every divider-th takes a sample, from 0 on. False
  /// for `is_timely`: what the driver gives in it has no known instant and is not kept.
  void collect(drivers::Driver& driver, std::uint64_t cycle, bool is_timely) noexcept;

  /// Of the sample that the last cycle took: channel by channel.
  [[nodiscard]] std::span<const float> row() const noexcept { return row_; }
  /// All places NaN, for the next sample.
  void begin_sample() noexcept;

 private:
  struct Channel {
    std::size_t first = 0;  // of the row
    std::uint32_t values = 0;
  };
  [[nodiscard]] std::uint32_t place(const Channel& channel, unsigned cycle) const noexcept;

  const unsigned divider_;
  std::vector<Channel> channels_;
  std::vector<std::uint32_t> counts_;
  std::vector<float> given_;  // in one cycle
  std::vector<float> row_;
};

}  // namespace tonus::control
