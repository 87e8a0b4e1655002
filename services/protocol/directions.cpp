#include "services/protocol/directions.hpp"

#include <algorithm>
#include <cmath>

namespace tonus::protocol {
namespace {

constexpr double kSteepest = 50.0;  // e^-50: the directions that have come more often are as good as left out
constexpr int kHalvings = 60;

std::vector<double> chances_of(std::span<const int> counts, double steepness) {
  const int least = *std::min_element(counts.begin(), counts.end());
  std::vector<double> chances;
  double sum = 0.0;
  for (const int count : counts) {
    chances.push_back(std::exp(-steepness * (count - least)));
    sum += chances.back();
  }
  for (double& chance : chances) chance /= sum;
  return chances;
}

}  // namespace

double entropy_of(std::span<const double> chances) {
  double bits = 0.0;
  for (const double chance : chances) bits -= chance > 0.0 ? chance * std::log2(chance) : 0.0;
  return bits;
}

std::vector<double> direction_chances(std::span<const int> counts, double entropy) {
  std::vector<double> chances = chances_of(counts, kSteepest);
  if (entropy_of(chances) >= entropy) return chances;
  double low = 0.0;  // has entropy enough
  double high = kSteepest;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (entropy_of(chances_of(counts, middle)) >= entropy ? low : high) = middle;
  }
  return chances_of(counts, low);
}

std::size_t draw_by(std::span<const double> chances, Draws& draws) {
  double left = draws.uniform(0.0, 1.0);
  for (std::size_t i = 0; i < chances.size(); ++i) {
    left -= chances[i];
    if (left < 0.0) return i;
  }
  // Rounding may leave a rest: it goes to the likeliest.
  return static_cast<std::size_t>(std::max_element(chances.begin(), chances.end()) - chances.begin());
}

}  // namespace tonus::protocol
