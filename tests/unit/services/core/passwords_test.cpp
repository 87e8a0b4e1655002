#include "services/core/passwords.hpp"

#include <gtest/gtest.h>

namespace tonus {
namespace {

TEST(WithoutPasswords, HidesAPasswordWhateverItHolds) {
  const std::string passwords[] = {"p", "p@ss", "p@s@s", "it's", "a\"b", "a:b", "a/b", "a b", "@", "'"};
  for (const std::string& password : passwords) {
    EXPECT_EQ(without_passwords("store = \"postgresql://ann:" + password + "@host/db\"\nnext = 1"),
              "store = \"postgresql://ann:***@host/db\"\nnext = 1")
        << password;
  }
}

TEST(WithoutPasswords, HidesParametersWhateverTheyHold) {
  EXPECT_EQ(without_passwords("\"postgresql://host/db?password=it's&x=1\""),
            "\"postgresql://host/db?password=***&x=1\"");
  EXPECT_EQ(without_passwords("\"postgresql://host/db?Password=a\"b\""),
            "\"postgresql://host/db?Password=***\"");
  EXPECT_EQ(without_passwords("host=h password='my \\' pass' user=u"), "host=h password=*** user=u");
  EXPECT_EQ(without_passwords("password = abc"), "password = ***");
}

TEST(WithoutPasswords, LeavesTheRestAsItIs) {
  for (const char* text :
       {"", "\n", "a\n\nb\n", "postgresql://ann@host:5432/study", "at 10:30 write to ann@host",
        "/data/a:b@c.sqlite", "http://host:80/", "passwords are hidden"}) {
    EXPECT_EQ(without_passwords(text), text);
  }
}

TEST(WithoutPasswords, TakesLongLines) {
  const std::string text = "postgresql://ann:" + std::string(1'000'000, 'x') + "@host/db";
  EXPECT_EQ(without_passwords(text), "postgresql://ann:***@host/db");
}

}  // namespace
}  // namespace tonus
