#include "services/core/text_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

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

TEST(TextFile, IsReplacedWhereALinkLeadsAndTheLinkStays) {
  const testing::TemporaryFolder folder;
  ASSERT_TRUE(write_text_file(folder / "a.txt", "first"));
  std::filesystem::create_symlink("a.txt", folder / "link");
  ASSERT_TRUE(write_text_file(folder / "link", "second"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(*read_text_file(folder / "a.txt"), "second");
}

TEST(TextFile, IsNotPutInThePlaceOfALinkThatLeadsNowhereOrInCircles) {
  const testing::TemporaryFolder folder;
  std::filesystem::create_symlink("circle", folder / "circle");
  std::filesystem::create_symlink("missing", folder / "dangling");
  for (const char* name : {"circle", "dangling"}) {
    const auto outcome = write_text_file(folder / name, "text");
    ASSERT_FALSE(outcome) << name;
    EXPECT_EQ(outcome.error().code, ErrorCode::kIo) << name;
    EXPECT_TRUE(std::filesystem::is_symlink(folder / name)) << name;
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2);
}

TEST(TextFile, IsWrittenIntoAPipeAndADeviceWhichStayWhatTheyAre) {
  const testing::TemporaryFolder folder;
  const auto pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_FALSE(write_text_file(pipe, "text")) << "nobody reads it";
  FileDescriptor reader(open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  ASSERT_TRUE(reader.is_open());
  ASSERT_TRUE(write_text_file(pipe, "text"));
  std::string text(8, '\0');
  EXPECT_EQ(read(reader.get(), text.data(), text.size()), 4);
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
  const auto full = write_text_file("/dev/full", "text");
  ASSERT_FALSE(full);
  EXPECT_NE(full.error().message.find("/dev/full: cannot be written"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
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
