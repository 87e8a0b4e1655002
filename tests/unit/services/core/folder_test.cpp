#include "services/core/folder.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "services/core/text_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus {
namespace {

namespace fs = std::filesystem;

/// True where `holds` is true for somebody who is not root: root is refused nothing.
template <typename Holds>
bool for_somebody_else(const Holds& holds) {
  const pid_t child = ::fork();
  if (child == 0) {
    if (::geteuid() == 0 && (::setgid(65534) != 0 || ::setuid(65534) != 0)) ::_exit(2);
    ::_exit(holds() ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return status == 0;
}

TEST(IsPresent, TellsAbsentFromUnreachable) {
  const testing::TemporaryFolder folder;
  std::ofstream(folder / "file") << "x";
  EXPECT_TRUE(*is_present(folder / "file"));
  EXPECT_FALSE(*is_present(folder / "nothing"));
  EXPECT_FALSE(*is_present(folder / "file" / "below"));

  fs::create_symlink(folder / "gone", folder / "dangling");
  const auto dangling = is_present(folder / "dangling");
  ASSERT_FALSE(dangling);
  EXPECT_EQ(dangling.error().code, ErrorCode::kIo);
  EXPECT_EQ(dangling.error().message, (folder / "dangling").string() + ": cannot be reached: is a link to '" +
                                          (folder / "gone").string() + "', which does not exist");
  EXPECT_FALSE(is_present(folder / "dangling" / "below" / "it")) << "not absent: nobody can tell";
  fs::create_symlink(folder / "loop", folder / "loop");
  ASSERT_FALSE(is_present(folder / "loop"));
  fs::create_symlink(folder / "file", folder / "link");
  EXPECT_TRUE(*is_present(folder / "link"));

  fs::create_directory(folder / "closed");
  ::chmod((folder / "closed").c_str(), 0);
  EXPECT_TRUE(for_somebody_else([&] {
    const auto inside = is_present(folder / "closed" / "nothing");
    return !inside && inside.error().code == ErrorCode::kIo;
  }));
}

TEST(ListFolder, TellsAbsentFromUnreachableFromEmpty) {
  const testing::TemporaryFolder folder;
  fs::create_directory(folder / "empty");
  EXPECT_TRUE(list_folder(folder / "empty")->empty());
  EXPECT_EQ(list_folder(folder / "nothing").error().code, ErrorCode::kNotFound);
  fs::create_directory(folder / "closed");
  ::chmod((folder / "closed").c_str(), 0);
  EXPECT_TRUE(for_somebody_else([&] {
    const auto closed = list_folder(folder / "closed");
    return !closed && closed.error().code == ErrorCode::kIo;
  }));
}

TEST(FilesBelow, DoesNotLoseAllToWhatCannotBeReached) {
  const testing::TemporaryFolder folder;
  fs::create_directories(folder / "a" / "b");
  fs::create_directory(folder / "closed");
  ::chmod((folder / "closed").c_str(), 0);
  std::ofstream(folder / "a" / "b" / "one") << "12345";
  std::ofstream(folder / "two") << "x";
  fs::create_symlink(folder / "loop", folder / "loop");
  fs::create_symlink(folder / "gone", folder / "dangling");
  fs::create_symlink(folder.path(), folder / "a" / "above");
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  ::chmod(folder.path().c_str(), 0755);
  EXPECT_TRUE(for_somebody_else([&] {
    const FilesBelow below = files_below(folder.path());
    return below.files.size() == 2 && below.files[0].relative == "a/b/one" && below.files[0].bytes == 5 &&
           below.files[1].relative == "two" && below.unreachable.size() == 3;
  }));
}

TEST(ReadTextFile, NeitherWaitsForAPipeNorTakesMemoryForAHole) {
  const testing::TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(read_text_file(folder / "pipe").error().message,
            (folder / "pipe").string() + ": cannot be read: not a regular file");
  std::ofstream(folder / "hole") << "x";
  fs::resize_file(folder / "hole", std::uintmax_t{30} << 30U);
  EXPECT_EQ(read_text_file(folder / "hole").error().message,
            (folder / "hole").string() + ": 32212254720 bytes are not allowed; expected at most 268435456");
}

TEST(ReadTextFile, DoesNotCallALinkToNothingAbsent) {
  const testing::TemporaryFolder folder;
  fs::create_symlink(folder / "gone", folder / "dangling");
  EXPECT_EQ(read_text_file(folder / "dangling").error().code, ErrorCode::kIo);
  EXPECT_EQ(read_text_file(folder / "gone").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace tonus
