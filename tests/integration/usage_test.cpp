// What a person gets who uses the programs wrongly: one line that helps, and the right exit code.

#include <algorithm>
#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/integration/program_run.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {
namespace {

using ::testing::HasSubstr;

constexpr std::chrono::seconds kLimit{60};
constexpr int kFailed = 1;
constexpr int kRefused = 2;
constexpr int kInterrupted = 130;

const std::string kArchive = source_file("tests/acceptance/recorded_session/session.sqlite").string();
const std::string kProtocol = source_file("deploy/protocols/unloaded.toml").string();

std::string content_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// A wrong use of `tonus`. {folder}, {domain}, {archive}, {protocol} stand for what the test has.
struct WrongUse {
  const char* name;
  std::vector<std::string> words;
  int code;
  std::vector<std::string> expected;  ///< All in the one line.
  const char* shell = "\"$@\"";
};

const std::vector<WrongUse> kWrongUses{
    {"UnknownCommand", {"statsu"}, kRefused, {"'statsu' is not a command", "did you mean status?"}},
    {"UnknownCommandLikeNone",
     {"mesure-everything"},
     kRefused,
     {"'mesure-everything'", "tonus --help lists"}},
    {"NoCommand", {}, kRefused, {"command is missing", "--help"}},
    {"UnknownCommandBelowACommand", {"pki", "isue"}, kRefused, {"tonus pki: 'isue'", "did you mean issue?"}},
    {"MisspeltOption", {"run", "--atach"}, kRefused, {"tonus run: --atach", "did you mean --attach?"}},
    {"MisspeltOptionWithAValue", {"status", "--domian=3"}, kRefused, {"--domian", "did you mean --domain?"}},
    {"MisspeltOptionOfTheProgram", {"--verson"}, kRefused, {"--verson", "did you mean --version?"}},
    {"VerboseAndQuiet", {"status", "-v", "-q"}, kRefused, {"excludes"}},
    {"MisspeltKeyOfAProtocol",
     {"run", "--dry-run", "{folder}/misspelt.toml"},
     kFailed,
     {"misspelt.toml:", "confirm_postur: unknown key", "did you mean confirm_posture?"}},
    {"MisspeltKeyOfTheConfiguration",
     {"status", "--config", "{folder}/tonus.toml"},
     kRefused,
     {"tonus.toml:1", "domian", "did you mean domain?"}},
    {"MisspeltReason", {"explain", "of", "target"}, kFailed, {"'of target'", "did you mean off target?"}},
    {"PostureOutOfReachInADryRun",
     {"run", "--dry-run", "{folder}/far.toml"},
     kFailed,
     {"far.toml", "posture[2].position_m", "0.1 to 0.9 m from the shoulder"}},
    {"StatusOfNoServices", {"status", "--domain", "{domain}"}, kFailed, {"no service", "tonus up"}},
    {"StatusOfNoServicesAsJson",
     {"status", "--json", "--domain", "{domain}"},
     kFailed,
     {"no service", "tonus up"}},
    {"PauseOfNoSession", {"pause", "--domain", "{domain}"}, kFailed, {"no session", "tonus up"}},
    {"ClearingNoRig", {"clear-fault", "--domain", "{domain}"}, kFailed, {"no rig 'rig'", "tonus up"}},
    {"AllSessionsInAFormatOfOne",
     {"export", "--all", "--format", "csv", "--out", "{folder}/out", "--archive", "{archive}"},
     kFailed,
     {"--format csv is not allowed", "expected bids"}},
    {"TruncatedArchive", {"ls", "--archive", "{folder}/short.sqlite"}, kFailed, {"cut off", "tonus recover"}},
    {"NoArchive", {"show", "--archive", "{folder}/none.sqlite"}, kFailed, {"none.sqlite", "no such file"}},
    {"FolderAsProtocol", {"run", "--dry-run", "{folder}"}, kFailed, {"is a folder", "protocol's TOML file"}},
    {"ArchiveAsProtocol",
     {"run", "--dry-run", "{archive}"},
     kFailed,
     {"is an archive", "protocol's TOML file"}},
    {"EmptyStandardInput",
     {"run", "--dry-run", "-"},
     kFailed,
     {"standard input: is empty"},
     "\"$@\" < /dev/null"},
    {"WrongStandardInput",
     {"run", "--dry-run", "-"},
     kFailed,
     {"standard input:1", "schema"},
     "echo 'schema = 7' | \"$@\""},
    {"TwoFilesFromStandardInput",
     {"run", "--dry-run", "-", "--profile", "-"},
     kFailed,
     {"standard input: is empty; expected a profile"},
     "\"$@\" < {protocol}"},
    {"HomeThatIsNotSet", {"ls"}, kFailed, {"HOME", "--data"}, "env -u HOME -u XDG_DATA_HOME \"$@\""},
};

class UsageFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string text = content_of(kProtocol);
    std::ofstream(folder_ / "misspelt.toml")
        << std::string(text).replace(text.find("confirm_posture"), 15, "confirm_postur");
    std::ofstream(folder_ / "far.toml")
        << std::string(text).replace(text.find("[0.000, 0.520]"), 14, "[0.000, 0.950]");
    std::ofstream(folder_ / "tonus.toml") << "domian = 3\n";
    std::ofstream(folder_ / "short.sqlite", std::ios::binary) << content_of(kArchive).substr(0, 3000);
  }

  [[nodiscard]] std::vector<std::string> filled(std::vector<std::string> words) const {
    for (auto& word : words) {
      for (const auto& [mark, value] :
           {std::pair<std::string, std::string>{"{folder}", folder_.path().string()},
            {"{domain}", std::to_string(own_domain())},
            {"{archive}", kArchive},
            {"{protocol}", kProtocol}}) {
        if (const auto at = word.find(mark); at != std::string::npos) word.replace(at, mark.size(), value);
      }
    }
    return words;
  }

  TemporaryFolder folder_;
};

class Usage : public UsageFiles, public ::testing::WithParamInterface<WrongUse> {};

TEST_P(Usage, WrongGetsOneLineThatHelpsAndItsExitCode) {
  const auto run =
      run_program("tonus", filled(GetParam().words), folder_.path(), filled({GetParam().shell})[0]);
  EXPECT_EQ(run.code, GetParam().code) << run.errors;
  EXPECT_EQ(std::count(run.errors.begin(), run.errors.end(), '\n'), 1) << run.errors;
  EXPECT_EQ(run.output, "");
  EXPECT_TRUE(run.errors.starts_with("tonus")) << run.errors;
  for (const auto& word : GetParam().expected) EXPECT_THAT(run.errors, HasSubstr(word));
}

INSTANTIATE_TEST_SUITE_P(Programs, Usage, ::testing::ValuesIn(kWrongUses),
                         [](const auto& use) { return use.param.name; });

/// Whether the process is `tonus` by now, and has a handler for Ctrl-C or keeps it for a thread that waits
/// for it.
bool is_ready_for_interrupt(pid_t process) {
  std::error_code error;
  const auto running = std::filesystem::read_symlink("/proc/" + std::to_string(process) + "/exe", error);
  if (error || running.filename() != "tonus") return false;
  std::istringstream status(content_of("/proc/" + std::to_string(process) + "/status"));
  for (std::string line; std::getline(status, line);) {
    if (!line.starts_with("SigCgt:") && !line.starts_with("SigBlk:")) continue;
    if ((std::stoull(line.substr(8), nullptr, 16) & (1ULL << (SIGINT - 1))) != 0) return true;
  }
  return false;
}

/// The commands, each where it lasts until somebody ends it: it waits for services, for input, or for a
/// reader of what it prints. A discovery server ends in order, as services do: below.
const std::vector<std::vector<std::string>> kLastingCommands{
    {"status", "--domain", "{domain}"},
    {"pause", "--domain", "{domain}"},
    {"resume", "--domain", "{domain}"},
    {"abort", "--domain", "{domain}"},
    {"stop", "--domain", "{domain}"},
    {"clear-fault", "--domain", "{domain}"},
    {"doctor", "--wait", "600", "--domain", "{domain}"},
    {"run", "{protocol}", "--domain", "{domain}"},
    {"run", "--attach", "--domain", "{domain}"},
    {"demo", "{protocol}", "--speed", "real", "--domain", "{domain}", "--data", "{folder}/data"},
    {"up", "--speed", "real", "--domain", "{domain}", "--data", "{folder}/data"},
    {"run", "--dry-run", "{protocol}"},
    {"ls", "--archive", "{archive}"},
    {"show", "--archive", "{archive}"},
    {"verify", "--archive", "{archive}"},
    {"identify", "{archive}"},
    {"export", "--archive", "{archive}", "--format", "csv", "--out", "{folder}/csv"},
    {"backup", "{folder}/backup.sqlite", "--archive", "{archive}"},
    {"copy", "{folder}/copy.sqlite", "--archive", "{archive}"},
    {"import", "{folder}/bids", "--archive", "{folder}/imported.sqlite"},
    {"recover", "{archive}", "--out", "{folder}/recovered.sqlite"},
    {"restore", "{archive}", "--archive", "{folder}/restored.sqlite"},
    {"report", "--cohort", "-", "--archive", "{archive}"},
    {"pki", "init", "--dds", "fastdds", "--authority", "{folder}/other-pki"},
    {"pki", "list", "--authority", "{folder}/pki"},
    {"pki", "issue", "host", "--role", "viewer", "--authority", "{folder}/pki"},
    {"pki", "renew", "--authority", "{folder}/pki"},
    {"pki", "revoke", "lost", "--authority", "{folder}/pki"},
    {"prune", "--older-than", "1", "--archive", "{archive}"},
    {"reject", "1", "--because", "coughed", "--domain", "{domain}"},
    {"note", "tired", "--domain", "{domain}"},
    {"certify", "--conditions", "1000000"},
    {"explain"},
    {"config", "--config", "none"},
};

class Interrupted : public UsageFiles {};

TEST_F(Interrupted, EveryCommandEndsWithOneLineAndTheCodeOfCtrlC) {
  const auto pipe = folder_ / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(reader, 0);
  const std::string much(65536, '.');
  while (write(reader, much.data(), much.size()) > 0) continue;  // nobody reads: whoever prints waits
  const auto silence = folder_ / "silence";                      // nobody writes: whoever reads waits
  ASSERT_EQ(mkfifo(silence.c_str(), 0600), 0);
  const int writer = open(silence.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(writer, 0);
  const std::string pki = folder_ / "pki";
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"pki", "init", "--dds", "fastdds", "--authority", pki},
           {"pki", "issue", "lost", "--role", "viewer", "--authority", pki},
           {"export", "--format", "bids", "--out", folder_ / "bids", "--archive", kArchive}})
    ASSERT_EQ(run_program("tonus", words, folder_.path()).code, 0);
  for (const auto& words : kLastingCommands) {
    const auto errors = folder_ / "errors";
    std::vector<std::string> all{
        "-c", "exec \"$@\" > " + pipe.string() + " 2> " + errors.string() + " < " + silence.string(), "sh",
        program("tonus").string()};
    const auto given = filled(words);
    all.insert(all.end(), given.begin(), given.end());
    Process process("/bin/sh", all, folder_ / "output");
    const auto deadline = std::chrono::steady_clock::now() + kLimit;
    while (!is_ready_for_interrupt(process.id()) && std::chrono::steady_clock::now() < deadline) usleep(1000);
    process.signal(SIGINT);
    EXPECT_EQ(process.wait(kLimit), kInterrupted) << words.front() << ": " << content_of(errors);
    const std::string said = content_of(errors);
    // Progress may stand above it.
    const auto before = said.size() < 2 ? std::string::npos : said.rfind('\n', said.size() - 2);
    const std::string last = said.substr(before == std::string::npos ? 0 : before + 1);
    EXPECT_TRUE(last.starts_with("tonus") && last.ends_with(": interrupted\n"))
        << words.front() << ": " << said;
  }
  close(reader);
  close(writer);
}

TEST_F(Interrupted, TheListHasEveryCommand) {
  std::set<std::string> named{"discovery-server"};
  for (const auto& words : kLastingCommands)
    named.insert(words[0] == "pki" ? words[0] + " " + words[1] : words[0]);
  const auto reference = run_program("tonus", {"--print-document", "reference"}, folder_.path());
  std::istringstream lines(reference.output);
  std::set<std::string> all;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("##") && line.find("tonus ") != std::string::npos)
      all.insert(line.substr(line.find("tonus ") + 6));
  }
  all.erase("pki");
  EXPECT_EQ(named, all);
}

TEST_F(Interrupted, ADiscoveryServerEndsInOrder) {
  const int domain = own_domain();
  Process server(
      program("tonus"),
      {"discovery-server", "--domain", std::to_string(domain), "--port", std::to_string(20'000 + domain)},
      folder_ / "server.log");
  ASSERT_TRUE(server.wait_for_output("discovery server of domain", kLimit)) << server.output();
  server.signal(SIGINT);
  EXPECT_EQ(server.wait(kLimit), 0) << server.output();
}

class RightUsage : public UsageFiles {};

TEST_F(RightUsage, ReadsAProtocolFromStandardInput) {
  const auto run = run_program("tonus", {"run", "--dry-run", "-"}, folder_.path(), "\"$@\" < " + kProtocol);
  EXPECT_EQ(run.code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("80 trials"));
}

TEST_F(RightUsage, EveryHelpHasAnExample) {
  const auto reference = run_program("tonus", {"--print-document", "reference"}, folder_.path());
  std::istringstream lines(reference.output);
  int commands = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("##")) continue;
    std::istringstream words(line.substr(line.find(' ')));
    std::vector<std::string> arguments;
    for (std::string word; words >> word;) arguments.push_back(word);
    ASSERT_EQ(arguments.front(), "tonus");
    arguments.erase(arguments.begin());
    const std::string name = line.substr(line.find("tonus"));
    arguments.emplace_back("--help");
    const auto help = run_program("tonus", arguments, folder_.path());
    EXPECT_EQ(help.code, 0) << line;
    EXPECT_THAT(help.output, HasSubstr("Example:\n  " + name)) << line;
    ++commands;
  }
  EXPECT_GT(commands, 25);
  for (const char* service :
       {"tonus-rig-agent", "tonus-scheduler", "tonus-identification", "tonus-archive", "tonus-dashboard"}) {
    const auto help = run_program(service, {"--help"}, folder_.path());
    EXPECT_THAT(help.output, HasSubstr(std::string("Example:\n  ") + service));
  }
}

}  // namespace
}  // namespace tonus::testing
