#pragma once

#include <array>
#include <cstdint>

#include "services/simulation/noise.hpp"

namespace tonus::simulation {

/// Surface EMG as band-limited noise: white normal noise through a Butterworth high-pass of second order at
/// 20 Hz and, where the rate leaves room for it, a low-pass at 450 Hz, scaled to a root mean square of 1.
/// Deterministic from seed and stream. next() is REALTIME.
class Electromyogram {
 public:
  /// `rate` of the values, Hz, more than 50.
  Electromyogram(double rate, std::uint64_t seed, std::uint64_t stream);

  /// The next value, with this root mean square.
  double next(double rms) noexcept { return rms * scale_ * filtered(noise_.normal()); }

 private:
  /// Second order, in the transposed direct form II; passes everything as it is made.
  struct Section {
    std::array<double, 3> b{1.0, 0.0, 0.0};
    std::array<double, 2> a{};
    std::array<double, 2> state{};

    double pass(double x) noexcept {
      const double y = b[0] * x + state[0];
      state[0] = b[1] * x - a[0] * y + state[1];
      state[1] = b[2] * x - a[1] * y;
      return y;
    }
  };
  [[nodiscard]] static Section butterworth(double corner, double rate, bool is_high_pass);
  double filtered(double x) noexcept { return low_.pass(high_.pass(x)); }

  NoiseSource noise_;
  Section high_;
  Section low_;
  double scale_ = 1.0;
};

}  // namespace tonus::simulation
