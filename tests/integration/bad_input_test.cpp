#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kLimit{30};

class BadInput : public ::testing::Test {
 protected:
  /// Runs `tonus` and checks that it refuses: exit code not 0, one line that holds every word of `expected`.
  void expect_refused(std::vector<std::string> arguments, const std::vector<std::string>& expected) {
    Process process(program("tonus"), arguments, folder_ / "output");
    const int code = process.wait(kLimit);
    const std::string text = process.output();
    EXPECT_GT(code, 0) << text;
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
    for (const auto& word : expected)
      EXPECT_NE(text.find(word), std::string::npos) << word << " in: " << text;
  }

  std::string protocol_with(const std::string& from, const std::string& to) {
    std::ifstream source(source_file("deploy/protocols/unloaded.toml"));
    std::string text((std::istreambuf_iterator<char>(source)), std::istreambuf_iterator<char>());
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) text.replace(at, from.size(), to);
    const auto path = folder_ / "protocol.toml";
    std::ofstream(path) << text;
    return path.string();
  }

  std::vector<std::string> demo(const std::string& protocol) const {
    return {
        "demo", protocol, "--domain", std::to_string(own_domain()), "--data", (folder_ / "data").string()};
  }

  TemporaryFolder folder_;
};

TEST_F(BadInput, UnknownOptionIsNamed) { expect_refused({"up", "--sped", "max"}, {"--sped"}); }

TEST_F(BadInput, OptionOfADashboardThatWasNotAskedForIsNamed) {
  expect_refused({"up", "--dashboard-allow-origin", "https://its.host"},
                 {"--dashboard-allow-origin", "requires --dashboard"});
}

TEST_F(BadInput, UnknownSubcommandIsNamed) { expect_refused({"mesure"}, {"mesure"}); }

TEST_F(BadInput, VendorThatIsNoneIsNamedWithTheOnesThatAre) {
  expect_refused({"up", "--dds", "opendds"}, {"--dds", "opendds", "fastdds", "cyclonedds"});
}

TEST_F(BadInput, ARigsNameCannotLeaveTheDataFolder) {
  for (const char* name : {"../x", "a/b", "..", ".hidden", "-x"})
    expect_refused({"up", "--rig=" + std::string(name), "--data", (folder_ / "data").string()},
                   {"--rig", "letters, digits"});
  for (const char* service : {"tonus-rig-agent", "tonus-archive", "tonus-scheduler", "tonus-dashboard"}) {
    Process process(program(service), {"--rig", "../x", "--data", (folder_ / "data").string()},
                    folder_ / "output");
    EXPECT_GT(process.wait(kLimit), 0) << service;
    EXPECT_NE(process.output().find("'../x' is not allowed"), std::string::npos) << process.output();
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "data"));
}

TEST_F(BadInput, DomainOutOfRangeIsNamedWithTheRange) {
  expect_refused({"up", "--domain", "500"}, {"--domain", "500", "232"});
}

TEST_F(BadInput, TextThatIsNoTomlIsNamedWithFileAndLine) {
  const auto path = folder_ / "protocol.toml";
  std::ofstream(path) << "schema = 1\nkind = = \"unloaded\"\n";
  expect_refused(demo(path.string()), {"protocol.toml:2"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "data"));
}

TEST_F(BadInput, ValueOutOfItsLimitsIsNamedWithThem) {
  expect_refused(demo(protocol_with("amplitude_m = 0.005", "amplitude_m = 5.0")), {"amplitude_m", "5"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "data"));
}

TEST_F(BadInput, PostureOutOfTheWorkspaceIsRefusedBeforeAnythingMoves) {
  expect_refused(demo(protocol_with("[0.000, 0.520]", "[0.000, 5.520]")), {"5.52"});
}

TEST_F(BadInput, MissingProtocolIsNamed) {
  expect_refused(demo("/nowhere/unloaded.toml"), {"/nowhere/unloaded.toml"});
}

TEST_F(BadInput, SubjectWhoIsNotInTheStudyIsNamedWithThoseWhoAre) {
  const auto study = source_file("deploy/protocols/study.toml").string();
  expect_refused({"run", study, "--subject", "s12"}, {"--subject 's12'", "study.toml", "s01, s02", "s11"});
}

TEST_F(BadInput, ResultsFileOfOneSessionIsNotTakenForAStudy) {
  const auto study = source_file("deploy/protocols/study.toml").string();
  expect_refused({"run", study, "--subject", "s01", "--json", (folder_ / "results.json").string()},
                 {"--json", "results.json", "study"});
}

TEST_F(BadInput, MissingDatasetIsNamed) {
  expect_refused({"demo", "--dataset", "/nowhere/dataset"}, {"--dataset", "/nowhere/dataset"});
}

TEST_F(BadInput, BadProfileIsNamedWithKeyAndValue) {
  const auto path = folder_ / "profile.toml";
  std::ofstream(path) << "[subject]\nupper_arm_length_m = -1.0\n";
  auto arguments = demo(source_file("deploy/protocols/unloaded.toml").string());
  arguments.insert(arguments.end(), {"--profile", path.string()});
  expect_refused(arguments, {"profile.toml"});
}

TEST_F(BadInput, DomainInUseIsNamedWithItsHolder) {
  const std::string domain = std::to_string(own_domain());
  Process holder(program("tonus"), {"up", "--domain", domain, "--data", (folder_ / "first").string()},
                 folder_ / "holder");
  ASSERT_TRUE(holder.wait_for_output("ready", kLimit)) << holder.output();
  expect_refused({"up", "--domain", domain, "--data", (folder_ / "second").string()},
                 {"--domain " + domain, "in use", std::to_string(holder.id())});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "second"));
  holder.signal(SIGTERM);
  EXPECT_EQ(holder.wait(kLimit), 0) << holder.output();
}

}  // namespace
}  // namespace tonus::testing
