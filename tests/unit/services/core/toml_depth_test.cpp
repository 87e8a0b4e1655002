#include "services/core/toml_depth.hpp"

#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace tonus {
namespace {

std::string deep(std::size_t parts) {
  std::string key = "a";
  for (std::size_t i = 1; i < parts; ++i) key += ".a";
  return key;
}

TEST(TomlDepth, RefusesAKeyOfManyPartsWhereverItStands) {
  const std::string key = deep(100'000);
  for (const std::string& text :
       std::vector<std::string>{key + " = 1", "[" + key + "]", "[[" + key + "]]", "x = { " + key + " = 1 }",
                                "# note\nb = [{" + key + " = 1}]"}) {
    const auto checked = check_toml_depth("first = 1\n" + text, "p.toml");
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.error().code, ErrorCode::kInvalidArgument);
    EXPECT_NE(checked.error().message.find("a key of more than 16 parts is not allowed"), std::string::npos);
    EXPECT_TRUE(checked.error().message.starts_with("p.toml:")) << checked.error().message;
  }
  EXPECT_EQ(check_toml_depth("a = 1\n" + key + " = 1", "p.toml").error().message.substr(0, 9), "p.toml:2:");
}

TEST(TomlDepth, LooksNeitherIntoStringsNorIntoComments) {
  const std::string dots = deep(1000);
  for (const std::string& text : std::vector<std::string>{
           "# " + dots, "a = \"" + dots + "\"", "a = '" + dots + "'", "a = \"\"\"\n" + dots + "\n\"\"\"",
           "a = \"\\\"" + dots + "\"", deep(10) + " = 1.5", "a = [1.5, 2.5, 3.5]", "a = 'open" + dots}) {
    EXPECT_TRUE(check_toml_depth(text, "p.toml")) << text.substr(0, 30);
  }
}

}  // namespace
}  // namespace tonus
