#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace tonus::drivers {

/// The card behind the stand-in for libcomedi's calls (fake_comedi.cpp). Subdevices: 0 two analogue inputs, 1
/// two analogue outputs, 2 eight digital lines, 3 two counters. One card in a program; a test starts with a
/// new one.
struct FakeCard {
  std::string device = "/dev/comedi0";
  bool is_there = true;
  bool is_connected = true;         ///< false: every call that reads or writes a channel fails.
  bool takes_counter_modes = true;  ///< false: the counters cannot be set up.
  std::array<double, 2> input_range{-10.0, 10.0};
  std::uint32_t analogue_largest = 0xffff;  // 16 bits
  std::uint32_t counter_largest = 0xffff;   // 16 bits: wraps soon

  std::array<double, 2> volts_in{};
  std::array<std::uint32_t, 2> output{0x1234, 0x1234};
  std::array<std::uint32_t, 2> counter{};
  std::array<unsigned, 8> line{};

  int open_cards = 0;
  int armed_counters = 0;
  unsigned counter_mode = 0;

  [[nodiscard]] double volts_out(std::size_t i) const { return -10.0 + 20.0 * output[i] / analogue_largest; }
};

FakeCard& fake_card();

}  // namespace tonus::drivers
