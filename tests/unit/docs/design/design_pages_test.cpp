#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace tonus {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = TONUS_SOURCE_DIR;

/// Folders that hold what others wrote: builds, packages, version control.
bool is_foreign(const fs::path& folder) {
  const std::string name = folder.filename().string();
  return name.starts_with(".") || name == "build" || name == "node_modules";
}

/// The project's files whose names end so, below a folder.
std::vector<fs::path> files_below(const fs::path& folder, const std::vector<std::string>& extensions) {
  std::vector<fs::path> found;
  for (auto entry = fs::recursive_directory_iterator(folder); entry != fs::recursive_directory_iterator();
       ++entry) {
    if (entry->is_directory() && is_foreign(entry->path())) entry.disable_recursion_pending();
    const std::string extension = entry->path().extension().string();
    if (entry->is_regular_file() &&
        std::find(extensions.begin(), extensions.end(), extension) != extensions.end()) {
      found.push_back(entry->path());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

bool is_of_a_name(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// The name at the beginning of a text.
std::string_view leading_name(std::string_view text) {
  const auto end = std::find_if_not(text.begin(), text.end(), is_of_a_name);
  return text.substr(0, static_cast<std::size_t>(end - text.begin()));
}

/// What stands between each `open` and the next `close` behind it.
std::vector<std::string> enclosed(std::string_view text, std::string_view open, char close) {
  std::vector<std::string> found;
  for (auto begin = text.find(open); begin != std::string_view::npos; begin = text.find(open, begin)) {
    begin += open.size();
    const auto end = text.find(close, begin);
    if (end == std::string_view::npos) break;
    found.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return found;
}

/// "Suite.Test" of every GoogleTest in the sources, and the name of every add_test of CMake.
std::set<std::string> declared_tests() {
  std::set<std::string> names;
  for (const auto& file : files_below(kRoot / "tests", {".cpp", ".hpp"})) {
    const std::string text = text_of(file);
    for (const std::string_view macro : {"\nTEST(", "\nTEST_F(", "\nTEST_P(", "\nTYPED_TEST("}) {
      for (const std::string& both : enclosed(text, macro, ')')) {
        const std::string suite(leading_name(both));
        const auto comma = both.find_first_not_of(", \n", suite.size());
        if (comma == std::string::npos) continue;
        names.insert(suite + "." + std::string(leading_name(std::string_view(both).substr(comma))));
      }
    }
  }
  for (const auto& file : files_below(kRoot / "tests", {".txt"})) {
    for (const std::string& name : enclosed(text_of(file), "add_test(NAME ", ' ')) names.insert(name);
  }
  return names;
}

/// "Suite.Test": two names in upper camel case.
bool is_test_name(std::string_view code) {
  const std::string_view suite = leading_name(code);
  if (suite.empty() || suite.size() + 1 >= code.size() || code[suite.size()] != '.') return false;
  const std::string_view test = code.substr(suite.size() + 1);
  const auto is_upper = [](char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; };
  return leading_name(test) == test && is_upper(suite.front()) && is_upper(test.front());
}

/// A page cut at its headings of the second level; what comes before the first one is left out.
std::vector<std::string> sections_of(const std::string& page) {
  std::vector<std::string> sections;
  for (auto begin = page.find("\n## "); begin != std::string::npos;) {
    const auto end = page.find("\n## ", begin + 1);
    sections.push_back(page.substr(begin + 1, end == std::string::npos ? end : end - begin - 1));
    begin = end;
  }
  return sections;
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

TEST(DesignPages, NameOnlyTestsThatExist) {
  const auto declared = declared_tests();
  ASSERT_GT(declared.size(), 500U);
  int named = 0;
  for (const auto& page : files_below(kRoot / "docs" / "design", {".md"})) {
    for (const std::string& code : enclosed(text_of(page), "`", '`')) {
      if (!is_test_name(code) || code == "Suite.Test") continue;
      ++named;
      EXPECT_TRUE(declared.contains(code)) << page.filename() << ": no test is called " << code;
    }
  }
  EXPECT_GT(named, 50);
}

TEST(DesignPages, NameATestWithEveryAnswer) {
  const auto declared = declared_tests();
  int answers = 0;
  for (const auto& page : files_below(kRoot / "docs" / "design", {".md"})) {
    for (const std::string& section : sections_of(text_of(page))) {
      ++answers;
      const auto codes = enclosed(section, "`", '`');
      EXPECT_TRUE(std::any_of(codes.begin(), codes.end(),
                              [&](const std::string& code) { return declared.contains(code); }))
          << page.filename() << ": no test holds \"" << first_line(section) << "\"";
    }
  }
  EXPECT_GT(answers, 20);
}

TEST(DesignPages, NameOnlyFilesThatExist) {
  for (const auto& page : files_below(kRoot / "docs" / "design", {".md"})) {
    for (const std::string& code : enclosed(text_of(page), "`", '`')) {
      const bool is_path = code.starts_with("tests/") || code.starts_with("services/") ||
                           code.starts_with("rig_agent/") || code.starts_with("analysis_service/");
      if (!is_path) continue;
      EXPECT_TRUE(fs::exists(kRoot / code)) << page.filename() << ": there is no " << code;
    }
  }
}

/// The manual's pages that the programs print when it is built; BuiltManual checks the links to them.
bool is_printed(const std::string& page) {
  return page == "reasons.md" || page == "keys.md" || page == "options.md" || page == "formats.md";
}

TEST(Pages, LinkOnlyToFilesThatExist) {
  int links = 0;
  for (const auto& page : files_below(kRoot, {".md"})) {
    for (std::string target : enclosed(text_of(page), "](", ')')) {
      target = target.substr(0, target.find('#'));
      if (target.empty() || target.find("://") != std::string::npos) continue;
      if (page.parent_path() == kRoot / "docs" / "manual" && is_printed(target)) continue;
      ++links;
      EXPECT_TRUE(fs::exists(page.parent_path() / target))
          << fs::relative(page, kRoot) << " links to " << target << ", which does not exist";
    }
  }
  EXPECT_GT(links, 20);
}

/// The folders of an area that are targets of their own.
std::vector<fs::path> rooms_of(const fs::path& area) {
  std::vector<fs::path> rooms;
  for (const auto& entry : fs::directory_iterator(area)) {
    if (fs::exists(entry.path() / "CMakeLists.txt")) rooms.push_back(entry.path());
  }
  return rooms;
}

TEST(Rooms, AreDescribedByTheirAreaAndByThemselves) {
  for (const char* area : {"services", "rig_agent", "analysis_service"}) {
    const std::string page = text_of(kRoot / area / "README.md");
    const auto rooms = rooms_of(kRoot / area);
    EXPECT_GE(rooms.size(), 4U) << area;
    for (const auto& room : rooms) {
      const std::string name = "`" + room.filename().string() + "/`";
      EXPECT_NE(page.find(name), std::string::npos) << area << "/README.md does not list " << name;
      EXPECT_TRUE(fs::exists(room / "README.md")) << fs::relative(room, kRoot) << " has no README.md";
    }
  }
}

}  // namespace
}  // namespace tonus
