#include "services/cli/key_documents.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <set>

#include "services/config/toml_text.hpp"
#include "services/core/text_file.hpp"

namespace tonus::cli {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

KeyDocument document(const std::string& name) {
  for (auto& one : key_documents()) {
    if (one.name == name) return one;
  }
  return {};
}

const config::Key* key_of(const KeyDocument& document, const std::string& name) {
  for (const auto& key : document.keys) {
    if (key.name == name) return &key;
  }
  return nullptr;
}

TEST(KeyDocuments, SayWhatEveryKeyOfTheReadersIsAndNoOther) {
  for (const auto& document : key_documents()) {
    EXPECT_GT(document.keys.size(), 4U) << document.name;
    for (const auto& key : document.keys) {
      EXPECT_THAT(meaning_of(document, key.name), Not(IsEmpty()))
          << document.name << " has the key " << key.name
          << ": add its text to services/explain/key_texts.cpp";
    }
    for (const auto& text : document.texts)
      EXPECT_NE(key_of(document, std::string(text.name)), nullptr)
          << document.name << ": no reader asks for " << text.name;
  }
}

TEST(KeyDocuments, StateTypeRangeUnitAndDefaultAsTheCheckDoes) {
  const auto protocol = document("protocol");
  const auto* amplitude = key_of(protocol, "perturbation.amplitude_m");
  ASSERT_NE(amplitude, nullptr);
  EXPECT_EQ(amplitude->expected, "0.0005 to 0.03 m");
  EXPECT_TRUE(amplitude->is_needed);
  const auto* repeats = key_of(protocol, "perturbation.repeats");
  ASSERT_NE(repeats, nullptr);
  EXPECT_EQ(repeats->expected, "a whole number, 1 to 20");
  EXPECT_EQ(repeats->preset, "1");
  const auto* counter = key_of(document("comedi"), "comedi.encoders.counter_mode");
  ASSERT_NE(counter, nullptr);
  EXPECT_EQ(counter->preset, "none");
}

TEST(KeyDocuments, FindAKeyByItsLastPartInEveryKindOfFile) {
  EXPECT_THAT(explained_keys("limits.force_N"), HasSubstr("expected: 0.5 to 100 N; default: 30"));
  const std::string forces = explained_keys("force_N");
  EXPECT_THAT(forces, HasSubstr("bias.force_N"));
  EXPECT_THAT(forces, HasSubstr("subject.tremor.force_N"));
  EXPECT_EQ(explained_keys("orce_N"), "");
  EXPECT_EQ(explained_keys(""), "");
}

/// "posture[].name" of every value in a table.
void add_keys(std::set<std::string>& keys, const toml::table& table, const std::string& path) {
  for (const auto& [key, node] : table) {
    const std::string name = path.empty() ? std::string(key.str()) : path + "." + std::string(key.str());
    if (const auto* inner = node.as_table()) {
      add_keys(keys, *inner, name);
    } else if (const auto* list = node.as_array(); list != nullptr && list->is_array_of_tables()) {
      for (const auto& element : *list) add_keys(keys, *element.as_table(), name + "[]");
    } else {
      keys.insert(name);
    }
  }
}

TEST(KeyDocuments, HaveEveryKeyOfTheFilesThatAreShipped) {
  const std::filesystem::path root = TONUS_SOURCE_DIR;
  for (const auto& [name, folder] :
       {std::pair("protocol", "deploy/protocols"), std::pair("profile", "deploy/profiles")}) {
    const auto known = document(name);
    for (const auto& file : std::filesystem::directory_iterator(root / folder)) {
      if (file.path().filename() == "cohort.toml") continue;
      const auto text = read_text_file(file.path());
      ASSERT_TRUE(text);
      const auto table = config::parse_toml(*text, file.path().string());
      ASSERT_TRUE(table);
      std::set<std::string> keys;
      add_keys(keys, *table, "");
      for (const auto& key : keys) EXPECT_NE(key_of(known, key), nullptr) << file.path() << ": " << key;
    }
  }
}

TEST(KeyDocuments, MakeAPageOfAllKeys) {
  const std::string page = keys_page();
  for (const auto& document : key_documents()) {
    for (const auto& key : document.keys) EXPECT_THAT(page, HasSubstr("\n| `" + key.name + "` | "));
  }
}

}  // namespace
}  // namespace tonus::cli
