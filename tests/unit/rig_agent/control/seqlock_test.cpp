#include "rig_agent/control/seqlock.hpp"

#include <array>
#include <atomic>
#include <cstdint>
#include <gtest/gtest.h>
#include <thread>

namespace tonus::control {
namespace {

using Block = std::array<std::uint64_t, 11>;

TEST(Seqlock, GivesTheLastValueStored) {
  Seqlock<Block> lock;
  EXPECT_EQ(lock.load(), Block{});
  Block value;
  value.fill(7);
  lock.store(value);
  EXPECT_EQ(lock.load(), value);
}

TEST(Seqlock, NeverGivesAMixtureOfTwoValues) {
  Seqlock<Block> lock;
  std::atomic<bool> is_done{false};
  std::thread writer([&] {
    Block value;
    for (std::uint64_t i = 1; i <= 100'000; ++i) {
      value.fill(i);
      lock.store(value);
    }
    is_done.store(true);
  });
  std::uint64_t last = 0;
  bool is_whole = true;
  while (!is_done.load() && is_whole) {
    const Block value = lock.load();
    for (const std::uint64_t word : value) is_whole = is_whole && word == value[0];
    is_whole = is_whole && value[0] >= last;
    last = value[0];
  }
  EXPECT_TRUE(is_whole) << "after value " << last;
  writer.join();
  EXPECT_EQ(lock.load()[10], 100'000U);
}

}  // namespace
}  // namespace tonus::control
