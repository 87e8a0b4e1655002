#include "services/simulation/electromyogram.hpp"

#include <cmath>
#include <numbers>

namespace tonus::simulation {
namespace {

constexpr double kLowCorner = 20.0;    // Hz
constexpr double kHighCorner = 450.0;  // Hz
constexpr double kMostOfRate = 0.45;   // A corner above this share of the rate has no effect within the band.

}  // namespace

Electromyogram::Electromyogram(double rate, std::uint64_t seed, std::uint64_t stream)
    : noise_(seed, stream), high_(butterworth(kLowCorner, rate, true)) {
  if (kHighCorner < kMostOfRate * rate) low_ = butterworth(kHighCorner, rate, false);
  // White noise of variance 1 leaves a filter with the energy of the impulse's answer.
  double energy = 0.0;
  for (int i = 0; i < static_cast<int>(rate); ++i) {
    const double answer = filtered(i == 0 ? 1.0 : 0.0);
    energy += answer * answer;
  }
  high_.state = {};
  low_.state = {};
  scale_ = 1.0 / std::sqrt(energy);
}

// By the bilinear transform with the corner where it is wanted.
Electromyogram::Section Electromyogram::butterworth(double corner, double rate, bool is_high_pass) {
  const double w = std::tan(std::numbers::pi * corner / rate);
  const double norm = 1.0 / (1.0 + std::numbers::sqrt2 * w + w * w);
  Section section;
  const double b = is_high_pass ? norm : w * w * norm;
  section.b = {b, is_high_pass ? -2.0 * b : 2.0 * b, b};
  section.a = {2.0 * (w * w - 1.0) * norm, (1.0 - std::numbers::sqrt2 * w + w * w) * norm};
  return section;
}

}  // namespace tonus::simulation
