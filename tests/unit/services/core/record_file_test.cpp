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

void flip_bit(const std::filesystem::path& path, std::uint64_t offset) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(offset));
  const int byte = file.get();
  file.seekp(static_cast<std::streamoff>(offset));
  file.put(static_cast<char>(byte ^ 0x10));
}

TEST(RecordFile, DoesNotTakeSmallNumbersInATornEndForAnEmptyRecord) {
  const testing::TemporaryFolder folder;
  const auto path = folder / "log";
  std::string numbers(12, '\0');
  for (char i = 1; i < 9; ++i) numbers += std::string{i, '\0', '\0', '\0', '\0', '\0', '\0', '\0'};
  {
    auto file = RecordFile::open(path, {});
    ASSERT_TRUE(file->append(bytes("first")));
    ASSERT_TRUE(file->append(bytes(numbers)));
  }
  const auto whole = std::filesystem::file_size(path);
  for (std::uint64_t length = whole - 1; length >= 13; --length) {
    std::filesystem::resize_file(path, length);
    EXPECT_EQ(contents(path), std::vector<std::string>{"first"}) << length;
    EXPECT_EQ(std::filesystem::file_size(path), 13U) << length;
    std::filesystem::resize_file(path, 13);
    auto file = RecordFile::open(path, {});
    ASSERT_TRUE(file->append(bytes(numbers)));
  }
}

TEST(RecordFile, CutsADamagedEndWhenItsOwnerAsks) {
  const testing::TemporaryFolder folder;
  const auto path = folder / "log";
  {
    auto file = RecordFile::open(path, {});
    for (const char* record : {"first", "second", "third"}) ASSERT_TRUE(file->append(bytes(record)));
  }
  flip_bit(path, 10);
  flip_bit(path, std::filesystem::file_size(path) - 1);
  auto file = RecordFile::open(path, {});
  ASSERT_EQ(file->damage().size(), 2U);
  ASSERT_TRUE(file->cut_damaged_end());
  ASSERT_EQ(file->damage().size(), 1U);
  EXPECT_EQ(file->torn_bytes(), 13U);
  ASSERT_TRUE(file->cut_damaged_end()) << "damage with a record behind it stays";
  ASSERT_EQ(file->damage().size(), 1U);
  ASSERT_TRUE(file->append(bytes("fourth")));
  EXPECT_EQ(contents(path), (std::vector<std::string>{"second", "fourth"}));
}

TEST(RecordFile, LosesOneRecordToAFlippedBitWhereverItIs) {
  const testing::TemporaryFolder folder;
  const auto path = folder / "log";
  const std::vector<std::string> all{"first", std::string(300, 'b'), "third record"};
  std::vector<std::uint64_t> starts;
  {
    auto file = RecordFile::open(path, {});
    for (const auto& record : all) {
      starts.push_back(file->size());
      ASSERT_TRUE(file->append(bytes(record)));
    }
    starts.push_back(file->size());
  }
  // The last record's length is left out: where it names more than there is, its end looks torn.
  for (std::uint64_t offset = 0; offset < starts[3]; ++offset) {
    if (offset >= starts[2] && offset < starts[2] + 4) continue;
    const auto copy = folder / ("copy" + std::to_string(offset));
    std::filesystem::copy_file(path, copy);
    flip_bit(copy, offset);
    const std::size_t hit = offset < starts[1] ? 0 : offset < starts[2] ? 1 : 2;
    auto kept = all;
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(hit));
    std::uint64_t torn = 1;
    EXPECT_EQ(contents(copy, &torn), kept) << "bit flipped at " << offset;
    EXPECT_EQ(torn, 0U);
    EXPECT_EQ(std::filesystem::file_size(copy), starts[3]) << "damage is not cut";
    auto file = RecordFile::open(copy, {});
    ASSERT_EQ(file->damage().size(), 1U);
    EXPECT_EQ(file->damage()[0].offset, starts[hit]);
    EXPECT_EQ(file->damage()[0].count, starts[hit + 1] - starts[hit]);
    ASSERT_TRUE(file->append(bytes("later")));
    kept.emplace_back("later");
    EXPECT_EQ(contents(copy), kept) << "appended behind damage at " << offset;
    std::filesystem::remove(copy);
  }
}

TEST(RecordFile, ResumesBehindAPageThatWasOverwritten) {
  const testing::TemporaryFolder folder;
  const auto path = folder / "log";
  {
    auto file = RecordFile::open(path, {});
    for (int i = 0; i < 40; ++i) ASSERT_TRUE(file->append(bytes(std::to_string(i) + std::string(500, 'x'))));
  }
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(4096);
    file << std::string(4096, '\0');
  }
  const auto kept = contents(path);
  EXPECT_EQ(kept.size(), 31U);  // nine records of 509 or 510 bytes touch bytes 4096 to 8191
  EXPECT_EQ(kept.back(), "39" + std::string(500, 'x'));
  const auto file = RecordFile::open(path, {});
  ASSERT_EQ(file->damage().size(), 1U);
  EXPECT_NE(file->damage_text().find("are damaged, the first at byte "), std::string::npos)
      << file->damage_text();
}

TEST(RecordFile, CutsZerosThatAPowerFailureLeftAtTheEnd) {
  const testing::TemporaryFolder folder;
  const auto path = folder / "log";
  std::uint64_t whole = 0;
  {
    auto file = RecordFile::open(path, {});
    ASSERT_TRUE(file->append(bytes("kept")));
    whole = file->size();
  }
  std::filesystem::resize_file(path, whole + 5000);
  EXPECT_EQ(contents(path), std::vector<std::string>{"kept"});
  EXPECT_EQ(std::filesystem::file_size(path), whole);
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
