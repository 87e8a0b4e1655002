#include "services/core/text_file.hpp"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace tonus {
namespace {

TEST(TextFile, IsReadAsItWasWritten) {
  const testing::TemporaryFolder folder;
  ASSERT_TRUE(write_text_file(folder / "a.txt", "line\nline\0more"));
  ASSERT_TRUE(write_text_file(folder / "a.txt", "second"));
  EXPECT_EQ(*read_text_file(folder / "a.txt"), "second");
}

TEST(TextFile, LeavesNothingBesideAFileThatCannotBeWritten) {
  const testing::TemporaryFolder folder;
  const auto outcome = write_text_file(folder.path() / "missing" / "a.txt", "text");
  ASSERT_FALSE(outcome);
  EXPECT_NE(outcome.error().message.find("a.txt: cannot be written"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(TextFile, ThatIsMissingIsNamed) {
  const auto text = read_text_file("/nowhere/a.txt");
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace tonus
