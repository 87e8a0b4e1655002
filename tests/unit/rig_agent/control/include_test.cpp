#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace tonus::control {
namespace {

// The files of the realtime core. What starts and checks it (validation, realtime_setup) runs before the
// loop.
const std::vector<std::string> kNotRealtime = {"fault_text.hpp", "fault_text.cpp",     "validation.hpp",
                                               "validation.cpp", "realtime_setup.hpp", "realtime_setup.cpp"};

const std::vector<std::string> kForbidden = {
    "string",  "string_view", "mutex",    "shared_mutex",  "condition_variable",
    "future",  "thread",      "iostream", "ostream",       "istream",
    "sstream", "fstream",     "iomanip",  "format",        "functional",
    "map",     "list",        "deque",    "unordered_map", "filesystem",
    "regex"};
const std::vector<std::string> kForbiddenFolders = {"spdlog/",  "fmt/", "services/bus/", "services/runtime/",
                                                    "fastdds/", "dds/", "idl/"};

// What an #include line names, or nothing.
std::string included(const std::string& line) {
  if (!line.starts_with("#include ")) return "";
  const std::size_t begin = line.find_first_of("<\"");
  const std::size_t end = line.find_last_of(">\"");
  return begin == std::string::npos || end <= begin ? "" : line.substr(begin + 1, end - begin - 1);
}

bool is_forbidden(const std::string& header) {
  return std::find(kForbidden.begin(), kForbidden.end(), header) != kForbidden.end() ||
         std::any_of(kForbiddenFolders.begin(), kForbiddenFolders.end(),
                     [&](const std::string& folder) { return header.starts_with(folder); });
}

std::vector<std::filesystem::path> realtime_files() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(TONUS_SOURCE_DIR "/rig_agent/control")) {
    const std::string name = entry.path().filename().string();
    const bool is_source = name.ends_with(".hpp") || name.ends_with(".cpp");
    if (is_source && std::find(kNotRealtime.begin(), kNotRealtime.end(), name) == kNotRealtime.end()) {
      files.push_back(entry.path());
    }
  }
  return files;
}

TEST(RealtimeCore, IncludesNoBusLogLockStringOrStreamHeader) {
  const auto files = realtime_files();
  ASSERT_GE(files.size(), 15U);
  int includes = 0;
  for (const auto& file : files) {
    std::ifstream stream(file);
    std::string line;
    for (int number = 1; std::getline(stream, line); ++number) {
      const std::string header = included(line);
      includes += header.empty() ? 0 : 1;
      EXPECT_FALSE(is_forbidden(header)) << file.filename() << ":" << number << ": " << line;
    }
  }
  EXPECT_GT(includes, 50);
}

}  // namespace
}  // namespace tonus::control
