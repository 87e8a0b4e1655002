#include "services/core/places.hpp"

#include <cstdlib>
#include <gtest/gtest.h>
#include <map>
#include <optional>

#include "tests/support/temporary_folder.hpp"

namespace tonus {
namespace {

/// The variables that say where data are, set for one test.
class Places : public ::testing::Test {
 protected:
  Places() {
    for (const char* name : {"STATE_DIRECTORY", "XDG_DATA_HOME", "XDG_STATE_HOME", "HOME"}) {
      const char* value = std::getenv(name);
      before_[name] = value == nullptr ? std::nullopt : std::optional<std::string>(value);
      ::unsetenv(name);
    }
  }
  ~Places() override {
    for (const auto& [name, value] : before_) {
      if (value) set(name, *value);
      if (!value) ::unsetenv(name.c_str());
    }
  }

  static void set(const std::string& name, const std::string& value) {
    ::setenv(name.c_str(), value.c_str(), 1);
  }

  void expect_refused(const std::vector<std::string>& words) {
    const auto folder = default_data_folder();
    ASSERT_FALSE(folder) << folder->string();
    for (const auto& word : words)
      EXPECT_NE(folder.error().message.find(word), std::string::npos) << folder.error().message;
  }

  testing::TemporaryFolder folder_;
  std::map<std::string, std::optional<std::string>> before_;
};

TEST_F(Places, AreInTheUsersDataFolder) {
  set("HOME", (folder_ / "home").string());
  EXPECT_EQ(*default_data_folder(), folder_ / "home/.local/share/tonus");
  set("XDG_DATA_HOME", (folder_ / "data").string());
  EXPECT_EQ(*default_data_folder(), folder_ / "data/tonus");
}

TEST_F(Places, OfASystemServiceAreWhereSystemdSays) {
  set("HOME", "/");
  set("STATE_DIRECTORY", "/var/lib/tonus:/var/lib/other");
  EXPECT_EQ(*default_data_folder(), "/var/lib/tonus");
}

TEST_F(Places, AreNotGuessedWithoutAHome) {
  expect_refused({"HOME", "XDG_DATA_HOME", "--data"});
  set("HOME", "");
  set("XDG_DATA_HOME", "");
  expect_refused({"HOME", "XDG_DATA_HOME", "--data"});
}

TEST_F(Places, AreNotRelativeToWhereAProgramHappensToRun) {
  set("HOME", "home");
  expect_refused({"HOME: 'home'", "absolute", "--data"});
  set("XDG_DATA_HOME", "./data");
  expect_refused({"XDG_DATA_HOME: './data'", "absolute", "--data"});
}

TEST_F(Places, AreNotInAFolderThatEverybodyMayWriteTo) {
  const auto shared = folder_ / "shared";
  std::filesystem::create_directory(shared);
  std::filesystem::permissions(shared, std::filesystem::perms::all | std::filesystem::perms::sticky_bit);
  for (const char* name : {"HOME", "XDG_DATA_HOME"}) {
    set(name, shared.string());
    expect_refused({name, shared.string(), "everybody"});
  }
}

TEST_F(Places, AreNotTakenForEmptyWhileAnEarlierVersionsDataAreElsewhere) {
  set("HOME", folder_.path().string());
  std::filesystem::create_directories(folder_ / ".local/state/tonus");
  expect_refused({".local/state/tonus", ".local/share/tonus", "move"});
  std::filesystem::create_directories(folder_ / ".local/share/tonus");
  EXPECT_TRUE(default_data_folder());
}

TEST_F(Places, OfARigAreTheSameWhateverTheDataFolder) {
  set("HOME", folder_.path().string());
  const auto rig = default_rig_folder("left");
  ASSERT_TRUE(rig);
  EXPECT_EQ(rig->filename(), "left");
  EXPECT_EQ(rig->parent_path().filename(), "rigs");
}

}  // namespace
}  // namespace tonus
