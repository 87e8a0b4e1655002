#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/integration/program_run.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {
namespace {

namespace fs = std::filesystem;

TEST(ExportAll, WritesEverySessionOfAnArchiveAsOneDatasetThatCanBeImported) {
  const TemporaryFolder folder;
  const std::string data = (folder / "data").string();
  const std::string protocol = source_file("tests/acceptance/recorded_session/protocol.toml").string();
  // The same subject twice, and another one.
  for (const auto& [subject, seed] : {std::pair("s01", "1"), std::pair("s01", "2"), std::pair("s02", "1")}) {
    const auto run = run_program("tonus",
                                 {"demo", protocol, "--subject", subject, "--seed", seed, "--data", data,
                                  "--domain", std::to_string(own_domain())},
                                 folder.path());
    ASSERT_EQ(run.code, 0) << run.errors << run.output;
  }
  const auto out = folder / "study";
  const auto exported = run_program(
      "tonus", {"export", "--all", "--format", "bids", "--out", out.string(), "--data", data}, folder.path());
  ASSERT_EQ(exported.code, 0) << exported.errors;
  EXPECT_THAT(exported.output, ::testing::HasSubstr("3 sessions, 3 recordings"));
  std::set<std::string> labels;
  for (const auto& subject : {"sub-s01", "sub-s02"}) {
    for (const auto& session : fs::directory_iterator(out / subject)) {
      if (session.is_directory()) labels.insert(session.path().filename().string());
    }
  }
  EXPECT_EQ(labels.size(), 3U) << "each session has a label of its own";
  for (const auto& label : labels) {
    EXPECT_TRUE(fs::exists(out / "code" / label / "protocol.toml")) << label;
    EXPECT_TRUE(fs::exists(out / "sourcedata" / "tonus" / label / "session.json")) << label;
  }
  const auto imported = run_program(
      "tonus", {"import", out.string(), "--archive", (folder / "other.sqlite").string()}, folder.path());
  ASSERT_EQ(imported.code, 0) << imported.errors;
  const auto listed =
      run_program("tonus", {"ls", "--json", "--archive", (folder / "other.sqlite").string()}, folder.path());
  EXPECT_EQ(nlohmann::json::parse(listed.output)["sessions"].size(), 3U);
}

}  // namespace
}  // namespace tonus::testing
