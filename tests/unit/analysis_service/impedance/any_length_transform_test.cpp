#include "analysis_service/impedance/any_length_transform.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace tonus::impedance::test {
namespace {

using Complex = std::complex<double>;

std::vector<Complex> signal(std::size_t length) {
  std::vector<Complex> x(length);
  for (std::size_t n = 0; n < length; ++n) {
    const auto t = static_cast<double>(n);
    x[n] = {std::sin(0.7 * t) + 0.01 * t, std::cos(1.3 * t * t)};
  }
  return x;
}

// Against the definition, a sum of n^2 terms.
TEST(AnyLengthTransform, EqualsTheDefinitionAtLengthsOfLargePrimeFactors) {
  AnyLengthTransform transform;
  for (const std::size_t length : {2UL, 60UL, 101UL, 2 * 307UL, 997UL}) {
    const auto x = signal(length);
    std::vector<Complex> forward;
    std::vector<Complex> backward;
    transform.fwd(forward, x);
    transform.inv(backward, forward);
    ASSERT_EQ(forward.size(), length);
    for (std::size_t k = 0; k < length; k += 1 + length / 20) {
      Complex sum = 0.0;
      for (std::size_t n = 0; n < length; ++n)
        sum += x[n] * std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(k * n % length) /
                                          static_cast<double>(length));
      EXPECT_LT(std::abs(forward[k] - sum), 1e-11 * static_cast<double>(length)) << length << " at " << k;
      EXPECT_LT(std::abs(backward[k] / static_cast<double>(length) - x[k]),
                1e-12 * static_cast<double>(length))
          << length << " at " << k;
    }
  }
}

// The direct sum of this length is of 9 10^9 terms.
TEST(AnyLengthTransform, InvertsALongPrimeLength) {
  AnyLengthTransform transform;
  const auto x = signal(94'993);
  std::vector<Complex> forward;
  std::vector<Complex> backward;
  transform.fwd(forward, x);
  transform.inv(backward, forward);
  for (std::size_t n = 0; n < x.size(); n += 997) EXPECT_LT(std::abs(backward[n] / 94'993.0 - x[n]), 1e-9);
}

}  // namespace
}  // namespace tonus::impedance::test
