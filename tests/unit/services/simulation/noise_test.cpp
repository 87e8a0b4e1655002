#include "services/simulation/noise.hpp"

#include <gtest/gtest.h>

namespace tonus::simulation {
namespace {

TEST(NoiseSource, HasTheMomentsOfANormalDistribution) {
  NoiseSource noise(1, 0);
  constexpr int kCount = 200'000;
  double sum = 0.0;
  double squares = 0.0;
  double fourth = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const double x = noise.normal();
    sum += x;
    squares += x * x;
    fourth += x * x * x * x;
  }
  // Five standard errors: 1/sqrt(n), sqrt(2/n), sqrt(96/n).
  EXPECT_NEAR(sum / kCount, 0.0, 0.0112);
  EXPECT_NEAR(squares / kCount, 1.0, 0.0158);
  EXPECT_NEAR(fourth / kCount, 3.0, 0.11);
}

TEST(NoiseSource, RepeatsForOneSeedAndDiffersForAnotherOrAnotherStream) {
  NoiseSource first(3, 0);
  NoiseSource same(3, 0);
  NoiseSource other_seed(4, 0);
  NoiseSource other_stream(3, 1);
  const double x = first.uniform();
  EXPECT_EQ(same.uniform(), x);
  EXPECT_NE(other_seed.uniform(), x);
  EXPECT_NE(other_stream.uniform(), x);
}

}  // namespace
}  // namespace tonus::simulation
