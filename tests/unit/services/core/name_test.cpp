#include "services/core/name.hpp"

#include <gmock/gmock.h>

namespace tonus {
namespace {

using ::testing::HasSubstr;

TEST(Name, LettersDigitsHyphensAndUnderscoresAreAllowed) {
  for (const char* name : {"rig", "rig-2", "Left_arm", "7", "a"}) EXPECT_EQ(fault_of_name(name), "") << name;
  EXPECT_EQ(fault_of_name(std::string(64, 'a')), "");
}

TEST(Name, NothingThatLeavesAFolderHidesAFileOrLooksLikeAnOptionIsAllowed) {
  for (const char* name : {"", ".", "..", "../x", "/etc", "a/b", "a\\b", ".hidden", "-rf", "_x", "a b", "a.b",
                           "C:", "rig\n", "r\xc3\xa4g", "%2e%2e"})
    EXPECT_THAT(fault_of_name(name), HasSubstr("is not allowed; expected")) << name;
  EXPECT_NE(fault_of_name(std::string(65, 'a')), "");
  EXPECT_NE(fault_of_name(std::string_view("a\0b", 3)), "");
}

TEST(Name, WhatIsWrongIsSaidInOneLineThatSteersNoTerminal) {
  const std::string fault = fault_of_name("a\x1b[31m\nb" + std::string(1000, 'x'));
  EXPECT_EQ(fault.find_first_of("\x1b\n"), std::string::npos);
  EXPECT_LT(fault.size(), 250U);
}

}  // namespace
}  // namespace tonus
