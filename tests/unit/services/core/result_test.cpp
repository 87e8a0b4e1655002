#include "services/core/result.hpp"

#include <gtest/gtest.h>
#include <memory>

namespace tonus {
namespace {

Result<int> half(int number) {
  if (number % 2 != 0) return fail(ErrorCode::kInvalidArgument, "the number is odd");
  return number / 2;
}

Result<int> quarter(int number) {
  TONUS_TRY_ASSIGN(const int once, half(number));
  TONUS_TRY_ASSIGN(const int twice, half(once));
  return twice;
}

Result<void> check_even(int number) {
  TONUS_TRY(half(number));
  return {};
}

TEST(Result, TryHandsOnTheValueOrReturnsTheError) {
  EXPECT_EQ(quarter(12).value(), 3);
  EXPECT_EQ(quarter(6).error().message, "the number is odd");
  EXPECT_TRUE(check_even(2));
  EXPECT_EQ(check_even(3).error().code, ErrorCode::kInvalidArgument);
}

TEST(Result, TryMovesWhatCannotBeCopied) {
  const auto make = []() -> Result<std::unique_ptr<int>> { return std::make_unique<int>(7); };
  const auto read = [&make]() -> Result<int> {
    TONUS_TRY_ASSIGN(const auto pointer, make());
    return *pointer;
  };
  EXPECT_EQ(read().value(), 7);
}

TEST(ResultDeathTest, ReadingTheWrongAlternativeStopsEveryBuild) {
  EXPECT_DEATH((void)half(1).value(), "the number is odd");
  EXPECT_DEATH((void)*half(1), "the number is odd");
  EXPECT_DEATH((void)half(2).error(), "successful result");
  EXPECT_DEATH((void)check_even(2).error(), "successful result");
}

}  // namespace
}  // namespace tonus
