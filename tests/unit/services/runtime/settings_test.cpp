#include "services/runtime/settings.hpp"

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <regex>
#include <toml++/toml.h>

#include "services/runtime/option_documents.hpp"
#include "services/runtime/options.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::runtime {
namespace {

/// A variable for as long as it lives.
class Variable {
 public:
  Variable(std::string name, const std::string& value) : name_(std::move(name)) {
    ::setenv(name_.c_str(), value.c_str(), 1);
  }
  ~Variable() { ::unsetenv(name_.c_str()); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  std::string name_;
};

/// A program with options of every kind.
struct Program {
  explicit Program(const std::string& name) : app("made up", name) {
    add_common_options(app, common);
    app.add_option("--limit-MB", limit, "most that it takes")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    app.add_option("--store", store, "where to");
    app.add_option("--profile", profile, "of the rig");
    app.add_flag("--fast", is_fast, "in haste");
    auto* certificate = app.add_option("--certificate", certificate_file, "PEM");
    auto* key = app.add_option("--key", key_file, "PEM");
    certificate->needs(key);
    key->needs(certificate);
    auto* step = app.add_subcommand("step", "one step");
    step->fallthrough();
    step->add_option("--operator", by, "who")->required();
  }

  CLI::App app;
  CommonOptions common;
  int limit = 5;
  std::string store;
  std::string profile;
  bool is_fast = false;
  std::string certificate_file;
  std::string key_file;
  std::string by;
};

class SettingsTest : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) {
    const auto path = folder_.path() / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
    return path.string();
  }

  /// Parses with the file; -1 where the program would go on.
  int parse(Program& program, std::vector<std::string> words = {}) {
    if (std::find(words.begin(), words.end(), "--config") == words.end())
      words.insert(words.begin(), {"--config", (folder_.path() / "tonus.toml").string()});
    words.insert(words.begin(), "program");
    std::vector<char*> argv;
    for (auto& word : words) argv.push_back(word.data());
    ::testing::internal::CaptureStderr();
    ::testing::internal::CaptureStdout();
    const int code = parse_command_line(program.app, static_cast<int>(argv.size()), argv.data());
    printed_ = ::testing::internal::GetCapturedStdout();
    said_ = ::testing::internal::GetCapturedStderr();
    return code;
  }

  testing::TemporaryFolder folder_;
  std::string said_;
  std::string printed_;
};

TEST_F(SettingsTest, TheCommandLineWinsOverTheEnvironmentAndThatOverTheFile) {
  write("tonus.toml", "domain = 3\ndds = \"cyclonedds\"\nrig = \"left\"\n");
  const Variable domain("TONUS_DOMAIN", "4");
  const Variable rig("TONUS_RIG", "middle");
  Program program("tonus-archive");
  ASSERT_EQ(parse(program, {"--rig", "right"}), -1) << said_;
  EXPECT_EQ(program.common.dds, "cyclonedds");
  EXPECT_EQ(program.common.domain, 4);
  EXPECT_EQ(program.common.rig, "right");
}

TEST_F(SettingsTest, ASectionWinsOverTheTop) {
  write("tonus.toml",
        "domain = 3\n[archive]\ndomain = 5\nlimit-MB = 7\nfast = true\n[scheduler]\ndomain = 9\n");
  Program program("tonus-archive");
  ASSERT_EQ(parse(program), -1) << said_;
  EXPECT_EQ(program.common.domain, 5);
  EXPECT_EQ(program.limit, 7);
  EXPECT_TRUE(program.is_fast);
}

TEST_F(SettingsTest, AFlagOfTheFileCanBeTakenBack) {
  write("tonus.toml", "[archive]\nfast = true\n");
  Program program("tonus-archive");
  ASSERT_EQ(parse(program, {"--fast=false"}), -1) << said_;
  EXPECT_FALSE(program.is_fast);
}

TEST_F(SettingsTest, EveryOptionHasAVariableOfTheProgramAndTheCommonOnesOneOfAll) {
  const Variable limit("TONUS_ARCHIVE_LIMIT_MB", "8");
  const Variable all("TONUS_DOMAIN", "4");
  const Variable own("TONUS_ARCHIVE_DOMAIN", "6");
  const Variable peers("TONUS_PEERS", "10.0.0.1,10.0.0.2");
  write("tonus.toml", "");
  Program program("tonus-archive");
  ASSERT_EQ(parse(program), -1) << said_;
  EXPECT_EQ(program.limit, 8);
  EXPECT_EQ(program.common.domain, 6);
  EXPECT_EQ(program.common.peers, (std::vector<std::string>{"10.0.0.1", "10.0.0.2"}));
}

TEST_F(SettingsTest, ListsComeFromTheFileAndAreReplacedAsAWhole) {
  write("tonus.toml", "peers = [\"10.0.0.1\", \"10.0.0.2\"]\n");
  Program program("tonus-archive");
  ASSERT_EQ(parse(program), -1) << said_;
  EXPECT_EQ(program.common.peers, (std::vector<std::string>{"10.0.0.1", "10.0.0.2"}));
  Program other("tonus-archive");
  ASSERT_EQ(parse(other, {"--peers", "10.0.0.9"}), -1) << said_;
  EXPECT_EQ(other.common.peers, (std::vector<std::string>{"10.0.0.9"}));
}

TEST_F(SettingsTest, AnUnknownKeyIsOneLineWithTheKeyThatWasProbablyMeant) {
  const auto file = write("tonus.toml", "domain = 3\n\n[archive]\nlimit-MD = 7\n");
  Program program("tonus-archive");
  EXPECT_EQ(parse(program), 2);
  EXPECT_EQ(said_, "tonus-archive: " + file + ":4: archive.limit-MD: unknown key; did you mean limit-MB?\n");
}

TEST_F(SettingsTest, UnknownKeysAndTablesAtTheTopAreRefused) {
  for (const std::string text :
       {"domian = 3\n", "[archiv]\nlimit-MB = 3\n", "limit-MB = 3\n", "archive = 3\n",
        "[archive.other]\nx = 1\n", "domain = { a = 1 }\n", "[[archive]]\nlimit-MB = 3\n"}) {
    write("tonus.toml", text);
    Program program("tonus-archive");
    EXPECT_EQ(parse(program), 2) << text;
    EXPECT_EQ(std::count(said_.begin(), said_.end(), '\n'), 1) << said_;
  }
  EXPECT_EQ(parse(*std::make_unique<Program>("tonus-archive"), {"--help"}), 0);
}

TEST_F(SettingsTest, OtherProgramsSectionsAreLeftToThem) {
  write("tonus.toml", "[dashboard]\nlisten = \"0.0.0.0:80\"\n[rig-agent]\ndriver = \"x\"\n");
  Program program("tonus-archive");
  EXPECT_EQ(parse(program), -1) << said_;
}

TEST_F(SettingsTest, AProgramWithoutCommonOptionsLeavesThemToTheOthers) {
  const Variable named("TONUS_CONFIG", write("tonus.toml", "domain = 3\n[tool]\nlevel = 2\n"));
  CLI::App app("made up", "tonus-tool");
  int level = 1;
  app.add_option("--level", level, "of detail");
  std::string word = "tonus-tool";
  char* argv[] = {word.data()};
  EXPECT_EQ(parse_command_line(app, 1, argv), -1);
  EXPECT_EQ(level, 2);
}

TEST_F(SettingsTest, AValueThatIsNotAllowedNamesFileLineKeyAndLimits) {
  const auto file = write("tonus.toml", "domain = 300\n");
  Program program("tonus-archive");
  EXPECT_EQ(parse(program), 2);
  EXPECT_EQ(said_, "tonus-archive: " + file +
                       ":1: domain: 300 is not allowed: --domain: Value 300 not in range 0 to 232\n");
  for (const std::string text :
       {"domain = \"x\"\n", "domain = 1.5\n", "domain = true\n", "domain = [1, 2]\n", "dds = \"corba\"\n",
        "domain = 1979-05-27\n", "domain =", "domain = 1\ndomain = 2\n"}) {
    write("tonus.toml", text);
    Program other("tonus-archive");
    EXPECT_EQ(parse(other), 2) << text;
    EXPECT_EQ(std::count(said_.begin(), said_.end(), '\n'), 1) << said_;
  }
}

TEST_F(SettingsTest, AFileThatIsNamedHasToBeThere) {
  Program program("tonus-archive");
  EXPECT_EQ(parse(program), 2);
  EXPECT_NE(said_.find("no such file"), std::string::npos) << said_;
  Program without("tonus-archive");
  EXPECT_EQ(parse(without, {"--config", "none"}), -1) << said_;
}

TEST_F(SettingsTest, OptionsThatNeedEachOtherMayStandInDifferentPlaces) {
  write("tonus.toml", "[archive]\ncertificate = \"a.pem\"\n");
  Program alone("tonus-archive");
  EXPECT_EQ(parse(alone), 2);
  EXPECT_NE(said_.find("certificate needs key"), std::string::npos) << said_;
  Program both("tonus-archive");
  EXPECT_EQ(parse(both, {"--key", "b.pem"}), -1) << said_;
  EXPECT_EQ(both.certificate_file, "a.pem");
}

TEST_F(SettingsTest, WhatACommandMustBeToldMayStandInTheFile) {
  write("tonus.toml", "[rig-agent.step]\noperator = \"Ann\"\n");
  Program program("tonus-rig-agent");
  ASSERT_EQ(parse(program, {"step"}), -1) << said_;
  EXPECT_EQ(program.by, "Ann");
}

TEST_F(SettingsTest, TheRigsFileIsItsProfileAndHasTheAgentsOptions) {
  write("tonus.toml", "rig = \"left\"\n[rig-agent]\nlimit-MB = 7\nstore = \"host\"\n");
  const auto rig = write("rigs/left.toml", "[agent]\nlimit-MB = 9\n[loop]\nrate_Hz = 500\n");
  write("rigs/right.toml", "[agent]\nlimit-MX = 9\n");
  Program left("tonus-rig-agent");
  ASSERT_EQ(parse(left), -1) << said_;
  EXPECT_EQ(left.limit, 9);
  EXPECT_EQ(left.store, "host");
  EXPECT_EQ(left.profile, rig);
  Program right("tonus-rig-agent");
  EXPECT_EQ(parse(right, {"--rig=right"}), 2);
  EXPECT_NE(said_.find("right.toml:2: agent.limit-MX: unknown key"), std::string::npos) << said_;
  Program other("tonus-archive");  // the rigs' files are the agent's
  EXPECT_EQ(parse(other, {"--rig=right"}), -1) << said_;
  EXPECT_EQ(other.profile, "");
}

TEST_F(SettingsTest, PrintsWhatIsInForceAsAFileThatGivesTheSameAgain) {
  const auto file =
      write("tonus.toml", "peers = [\"10.0.0.1\"]\n[archive]\nstore = \"postgresql://ann:p@host/x\"\n");
  const Variable dds("TONUS_DDS", "cyclonedds");
  Program program("tonus-archive");
  EXPECT_EQ(parse(program, {"--domain", "7", "--print-config"}), 0);
  const auto table = toml::parse(printed_);
  EXPECT_EQ(table["archive"]["domain"].value<int>(), 7);
  EXPECT_EQ(table["archive"]["dds"].value<std::string>(), "cyclonedds");
  EXPECT_EQ(table["archive"]["limit-MB"].value<int>(), 5);
  EXPECT_EQ(table["archive"]["store"].value<std::string>(), "postgresql://ann:***@host/x");
  ASSERT_NE(table["archive"]["peers"].as_array(), nullptr);
  for (const std::string line : {"# command line", "# TONUS_DDS in the environment", "# default"})
    EXPECT_NE(printed_.find(line), std::string::npos) << printed_;
  EXPECT_NE(printed_.find("# " + file + ":1"), std::string::npos) << printed_;
  EXPECT_NE(printed_.find("# " + file + ":3"), std::string::npos) << printed_;
  EXPECT_NE(printed_.find("# profile is not set"), std::string::npos) << printed_;
}

TEST_F(SettingsTest, TheConfigurationThatIsArchivedHasWhatTheFileSays) {
  write("tonus.toml", "domain = 9\n[archive]\nlimit-MB = 70\n");
  Program program("tonus-archive");
  ASSERT_EQ(parse(program), -1) << said_;
  const auto table = toml::parse(program.common.configuration);
  EXPECT_EQ(table["domain"].value<int>(), 9);
  EXPECT_EQ(table["limit-MB"].value<int>(), 70);
}

/// What three commands of the command line are told.
std::map<std::string, int> levels_in(const std::vector<std::string>& more) {
  std::map<std::string, int> levels;
  for (const std::string command : {"run", "show", "demo"}) {
    CLI::App app("made up", "tonus");
    std::map<std::string, int> values{{"run", 1}, {"show", 1}, {"demo", 1}};
    std::vector<CommonOptions> common(values.size());
    auto next = common.begin();
    for (auto& [name, value] : values) {
      auto* sub = app.add_subcommand(name, "a command");
      add_common_options(*sub, *next++);
      sub->add_option("--level", value, "of detail");
    }
    app.get_subcommand("demo")->get_option("--config")->default_str(kNoFile);
    std::vector<std::string> words{"tonus", command};
    words.insert(words.end(), more.begin(), more.end());
    std::vector<char*> argv;
    for (auto& word : words) argv.push_back(word.data());
    EXPECT_EQ(parse_command_line(app, static_cast<int>(argv.size()), argv.data()), -1);
    levels[command] = values[command];
  }
  return levels;
}

TEST_F(SettingsTest, CommandsHaveTablesOfTheirOwnBelowTheOneOfAll) {
  const Variable named("TONUS_CONFIG", write("tonus.toml", "[tonus]\nlevel = 2\n[tonus.run]\nlevel = 3\n"));
  EXPECT_EQ(levels_in({}), (std::map<std::string, int>{{"run", 3}, {"show", 2}, {"demo", 2}}));
  EXPECT_EQ(levels_in({"--config", "none"}),
            (std::map<std::string, int>{{"run", 1}, {"show", 1}, {"demo", 1}}));
}

TEST(SectionOfAProgram, IsItsNameWithoutTonus) {
  EXPECT_EQ(section_of("tonus-rig-agent"), "rig-agent");
  EXPECT_EQ(section_of("tonus"), "tonus");
}

TEST(Variables, AreNamedAfterSectionAndOption) {
  EXPECT_EQ(variables_of({"archive"}, "limit-MB", false), std::vector<std::string>{"TONUS_ARCHIVE_LIMIT_MB"});
  EXPECT_EQ(variables_of({"archive"}, "domain", true),
            (std::vector<std::string>{"TONUS_ARCHIVE_DOMAIN", "TONUS_DOMAIN"}));
  EXPECT_EQ(variables_of({"tonus", "run"}, "seed", false),
            (std::vector<std::string>{"TONUS_RUN_SEED", "TONUS_SEED"}));
}

TEST(OptionDocuments, NameEveryOptionWithItsRangeAndDefault) {
  Program program("tonus-archive");
  for (const std::string kind : {"man", "reference", "bash", "zsh"}) {
    const auto text = option_document(program.app, kind);
    ASSERT_TRUE(text) << text.error().message;
    for (const std::string option : {"limit-MB", "store", "domain", "peers", "operator", "fast"}) {
      std::string written = option;
      if (kind == "man") written = std::regex_replace(option, std::regex("-"), "\\-");
      EXPECT_NE(text->find(written), std::string::npos) << kind << " " << option;
    }
  }
  const auto man = option_document(program.app, "man");
  EXPECT_NE(man->find("Allowed: [1 \\- 100]. Default: 5."), std::string::npos) << *man;
  EXPECT_FALSE(option_document(program.app, "poem"));
}

TEST(OptionDocuments, TheKeysAreAFileThatChangesNothing) {
  Program program("tonus-archive");
  const auto text = option_document(program.app, "toml");
  ASSERT_TRUE(text);
  EXPECT_NO_THROW((void)toml::parse(*text)) << *text;
  // With the comment signs of the keys taken away it is a file, too.
  const auto open = std::regex_replace(*text, std::regex("\n#([a-z])"), "\n$1");
  EXPECT_EQ(toml::parse(open)["archive"]["limit-MB"].value<int>(), 5) << open;
}

}  // namespace
}  // namespace tonus::runtime
