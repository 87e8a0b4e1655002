#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace {

TEST(SameDigits, DependOnNoProcessorsCaches) {
  // The sizes of blocks without CPUID (Eigen's for x86-64). Other sizes sum products of matrices in another
  // order.
  EXPECT_EQ(Eigen::l1CacheSize(), 32 * 1024);
  EXPECT_EQ(Eigen::l2CacheSize(), 256 * 1024);
  EXPECT_EQ(Eigen::l3CacheSize(), 2 * 1024 * 1024);
}

}  // namespace
