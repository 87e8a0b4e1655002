#include "services/core/record_file.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "tests/support/temporary_folder.hpp"

namespace tonus {
namespace {

std::span<const std::byte> bytes(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

std::vector<std::string> contents(const std::filesystem::path& path, std::uint64_t* torn = nullptr) {
  std::vector<std::string> records;
  const auto file = RecordFile::open(path, [&](std::uint64_t, std::span<const std::byte> content) {
    records.emplace_back(reinterpret_cast<const char*>(content.data()), content.size());
  });
  EXPECT_TRUE(file) << file.error().message;
  if (torn != nullptr) *torn = file->torn_bytes();
  return records;
}

TEST(RecordFile, GivesBackWhatWasAppended) {
  const testing::TemporaryFolder folder;
  {
    auto file = RecordFile::open(folder / "log", {});
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->append(bytes("one")));
    ASSERT_TRUE(file->append(bytes("")));
    ASSERT_TRUE(file->append(bytes("three")));
    ASSERT_TRUE(file->sync());
  }
  EXPECT_EQ(contents(folder / "log"), (std::vector<std::string>{"one", "", "three"}));
}

TEST(RecordFile, TakesThePlaceOfAnotherFileAndGoesOnUnderItsName) {
  const testing::TemporaryFolder folder;
  {
    auto old = RecordFile::open(folder / "log", {});
    ASSERT_TRUE(old);
    ASSERT_TRUE(old->append(bytes("old")));
    auto fresh = RecordFile::open(folder / "log.new", {});
    ASSERT_TRUE(fresh);
    ASSERT_TRUE(fresh->append(bytes("new")));
    ASSERT_TRUE(fresh->rename_to(folder / "log"));
    EXPECT_EQ(fresh->path(), folder / "log");
    ASSERT_TRUE(fresh->append(bytes("newer")));
  }
  EXPECT_EQ(contents(folder / "log"), (std::vector<std::string>{"new", "newer"}));
  EXPECT_FALSE(std::filesystem::exists(folder / "log.new"));
}

TEST(RecordFile, ReadsARecordWhereAppendPutIt) {
  const testing::TemporaryFolder folder;
  auto file = RecordFile::open(folder / "log", {});
  ASSERT_TRUE(file);
  ASSERT_TRUE(file->append(bytes("first")));
  const auto offset = file->append(bytes("second"));
  ASSERT_TRUE(offset);
  const auto content = file->read(*offset);
  ASSERT_TRUE(content);
  EXPECT_EQ(content->size(), 6U);
  EXPECT_FALSE(file->read(*offset + 1));
}

TEST(RecordFile, CutsATornEndAtEveryLengthAndGoesOn) {
  const testing::TemporaryFolder folder;
  const auto path = folder / "log";
  std::uint64_t whole = 0;
  {
    auto file = RecordFile::open(path, {});
    ASSERT_TRUE(file->append(bytes("kept")));
    whole = file->size();
    ASSERT_TRUE(file->append(bytes("torn apart")));
  }
  const auto full = std::filesystem::file_size(path);
  for (auto length = full - 1; length > whole; --length) {
    const auto copy = folder / ("copy" + std::to_string(length));
    std::filesystem::copy_file(path, copy);
    std::filesystem::resize_file(copy, length);
    std::uint64_t torn = 0;
    EXPECT_EQ(contents(copy, &torn), std::vector<std::string>{"kept"}) << length;
    EXPECT_EQ(torn, length - whole);
    auto again = RecordFile::open(copy, {});
    ASSERT_TRUE(again->append(bytes("next")));
    EXPECT_EQ(contents(copy), (std::vector<std::string>{"kept", "next"}));
  }
}

TEST(RecordFile, StopsAtADamagedRecord) {
  const testing::TemporaryFolder folder;
  const auto path = folder / "log";
  {
    auto file = RecordFile::open(path, {});
    ASSERT_TRUE(file->append(bytes("good")));
    ASSERT_TRUE(file->append(bytes("damaged")));
  }
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(-1, std::ios::end);
  file.put('!');
  file.close();
  EXPECT_EQ(contents(path), std::vector<std::string>{"good"});
}

TEST(RecordFile, DoesNotTakeARunOfZerosForRecords) {
  const testing::TemporaryFolder folder;
  std::ofstream(folder / "log", std::ios::binary) << std::string(4096, '\0');
  EXPECT_TRUE(contents(folder / "log").empty());
}

TEST(RecordFile, NamesTheFileThatCannotBeOpened) {
  const auto file = RecordFile::open("/nowhere/log", {});
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().message, "/nowhere/log: cannot be opened: No such file or directory");
}

}  // namespace
}  // namespace tonus
