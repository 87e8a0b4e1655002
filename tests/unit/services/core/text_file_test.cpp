#include "services/core/text_file.hpp"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace tonus {
namespace {

TEST(TextFile, IsReadAsItWasWritten) {
  const testing::TemporaryFolder folder;
  const std::string text("\xEF\xBB\xBFline\r\nline\0more", 18);
  ASSERT_TRUE(write_text_file(folder / "a.txt", text));
  EXPECT_EQ(*read_text_file(folder / "a.txt"), text);
}

TEST(TextFile, IsReplacedAsAWhole) {
  const testing::TemporaryFolder folder;
  ASSERT_TRUE(write_text_file(folder / "a.txt", "the first, longer text"));
  ASSERT_TRUE(write_text_file(folder / "a.txt", "second"));
  EXPECT_EQ(*read_text_file(folder / "a.txt"), "second");
}

TEST(TextFile, IsCreatedOnlyWhereThereIsNone) {
  const testing::TemporaryFolder folder;
  ASSERT_TRUE(create_text_file(folder / "a.txt", "first"));
  const auto outcome = create_text_file(folder / "a.txt", "second");
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().code, ErrorCode::kIo);
  EXPECT_EQ(*read_text_file(folder / "a.txt"), "first");
}

TEST(TextFile, LeavesNothingBesideAFileThatCannotBeWritten) {
  const testing::TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "a.txt" / "in the way");
  const auto outcome = write_text_file(folder / "a.txt", "text");
  ASSERT_FALSE(outcome);
  EXPECT_NE(outcome.error().message.find("a.txt: cannot be written"), std::string::npos);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(TextFile, InAFolderThatIsMissingIsRefused) {
  const testing::TemporaryFolder folder;
  const auto outcome = write_text_file(folder.path() / "missing" / "a.txt", "text");
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(TextFile, ThatIsMissingIsNamed) {
  const auto text = read_text_file("/nowhere/a.txt");
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().code, ErrorCode::kNotFound);
  EXPECT_NE(text.error().message.find("/nowhere/a.txt: cannot be read"), std::string::npos);
}

TEST(TextFile, ThatIsAFolderIsNoTextFile) {
  const testing::TemporaryFolder folder;
  const auto text = read_text_file(folder.path());
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().code, ErrorCode::kIo);
  EXPECT_NE(text.error().message.find("not a regular file"), std::string::npos);
}

}  // namespace
}  // namespace tonus
