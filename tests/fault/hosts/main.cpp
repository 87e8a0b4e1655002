#include <cstdio>
#include <gtest/gtest.h>

#include "tests/support/bus/private_network.hpp"

// Before any thread: the hosts are made in a network of this process's own.
int main(int count, char** arguments) {
  testing::InitGoogleTest(&count, arguments);
  if (!testing::GTEST_FLAG(list_tests)) {
    if (auto entered = tonus::test::enter_private_network(); !entered)
      std::printf("no hosts can be made: %s\n", entered.error().message.c_str());
  }
  return RUN_ALL_TESTS();
}
