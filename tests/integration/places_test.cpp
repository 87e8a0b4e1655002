#include <fstream>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <thread>

#include "tests/integration/archive_file.hpp"
#include "tests/integration/program_run.hpp"
#include "tests/support/process.hpp"

namespace tonus::testing {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds kLimit{60};

class ProgramPlaces : public ::testing::Test {
 protected:
  /// What others than user and group may do with what is below a folder; empty: nothing.
  static std::string open_to_others(const fs::path& folder) {
    std::string found;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      struct stat info {};
      if (::lstat(entry.path().c_str(), &info) == 0 && (info.st_mode & S_IRWXO) != 0)
        found += entry.path().string() + " ";
    }
    return found;
  }

  TemporaryFolder folder_;
};

TEST_F(ProgramPlaces, AreNotGuessedByAnyProgramThatNeedsOne) {
  const std::string domain = std::to_string(own_domain());
  fs::create_directory(folder_ / "dataset");
  const std::vector<std::pair<std::string, std::vector<std::string>>> programs{
      {"tonus-archive", {"--domain", domain}},
      {"tonus-scheduler", {"--domain", domain}},
      {"tonus-rig-agent", {"--domain", domain}},
      {"tonus-dashboard", {"--domain", domain}},
      {"tonus", {"up", "--domain", domain}},
      {"tonus", {"demo", source_file("deploy/protocols/unloaded.toml").string(), "--domain", domain}},
      {"tonus", {"ls"}},
      {"tonus", {"show"}},
      {"tonus", {"verify"}},
      {"tonus", {"export", "--format", "csv", "--out", (folder_ / "out").string()}},
  };
  for (const char* home : {"env -u HOME -u XDG_DATA_HOME -u STATE_DIRECTORY \"$@\"",
                           "HOME= XDG_DATA_HOME= STATE_DIRECTORY= \"$@\""}) {
    for (const auto& [name, arguments] : programs) {
      const auto run = run_program(name, arguments, folder_.path(), home);
      EXPECT_TRUE(is_refused_in_one_line(run)) << name << " " << arguments[0] << ": " << run.errors;
      EXPECT_NE(run.errors.find("set HOME or XDG_DATA_HOME"), std::string::npos)
          << name << ": " << run.errors;
    }
  }
}

TEST_F(ProgramPlaces, ThatWereRemovedUnderneathAProgramEndItInOneLine) {
  const std::string domain = std::to_string(own_domain());
  const std::string gone = (folder_ / "gone").string();
  const std::string shell = "mkdir " + gone + " && cd " + gone + " && rmdir " + gone + " && \"$@\"";
  const std::vector<std::pair<std::string, std::vector<std::string>>> programs{
      {"tonus", {"status", "--domain", domain, "--security", "certificates"}},
      {"tonus", {"up", "--domain", domain, "--data", "data"}},
      {"tonus", {"identify", "dataset"}},
      {"tonus-archive", {"--domain", domain, "--data", "data"}},
      {"tonus-rig-agent", {"--domain", domain, "--data", "data"}},
  };
  for (const auto& [name, arguments] : programs) {
    const auto run = run_program(name, arguments, folder_.path(), shell);
    EXPECT_TRUE(is_refused_in_one_line(run)) << name << " " << arguments[0] << ": " << run.errors;
  }
}

TEST_F(ProgramPlaces, ThatAreLinksInCirclesEndNoIdentification) {
  const auto dataset = folder_ / "dataset";
  const auto archive = source_file("tests/acceptance/recorded_session/session.sqlite").string();
  ASSERT_EQ(
      run_program("tonus", {"export", "--format", "bids", "--archive", archive, "--out", dataset.string()},
                  folder_.path())
          .code,
      0);
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(dataset))
    if (entry.is_regular_file()) files.push_back(entry.path());
  for (const auto& file : files) {
    const auto kept = folder_ / "kept";
    fs::rename(file, kept);
    fs::create_symlink(file.filename(), file);
    const auto run = run_program("tonus", {"identify", dataset.string()}, folder_.path());
    EXPECT_TRUE(run.code == 0 || is_refused_in_one_line(run)) << file << ": " << run.errors;
    fs::remove(file);
    fs::rename(kept, file);
  }
  fs::create_symlink("circle", folder_ / "circle");
  const auto run = run_program("tonus", {"identify", (folder_ / "circle").string()}, folder_.path());
  EXPECT_TRUE(is_refused_in_one_line(run)) << run.errors;
}

TEST_F(ProgramPlaces, AreTheUsersOwn) {
  const auto home = folder_ / "home";
  fs::create_directory(home);
  Process archive("/usr/bin/env",
                  {"-u", "XDG_DATA_HOME", "-u", "XDG_STATE_HOME", "HOME=" + home.string(),
                   program("tonus-archive").string(), "--domain", std::to_string(own_domain())},
                  folder_ / "output");
  ASSERT_TRUE(archive.wait_for_output("store '", kLimit)) << archive.output();
  EXPECT_TRUE(fs::exists(home / ".local/share/tonus/archive.sqlite")) << archive.output();
}

TEST_F(ProgramPlaces, KeepWhatIsASubjectsFromOthersWhateverTheMask) {
  const auto data = folder_ / "data";
  const std::string domain = std::to_string(own_domain());
  {
    Process up("/bin/sh",
               {"-c", "umask 000; exec \"$@\"", "sh", program("tonus").string(), "demo", "--domain", domain,
                "--data", data.string(), "--speed", "max", "--json", (data / "results.json").string(),
                source_file("tests/browser/short.toml").string()},
               folder_ / "output");
    ASSERT_TRUE(up.wait_for_output("archive: ", kLimit)) << up.output();
  }
  EXPECT_EQ(open_to_others(data), "");
  EXPECT_TRUE(fs::exists(data / "archive.sqlite"));
  EXPECT_TRUE(fs::exists(data / "rig/rig/hold"));

  const ArchiveFile archive;
  const auto out = folder_ / "out";
  fs::create_directory(out);
  for (const char* format : {"csv", "bids", "hdf5"}) {
    const auto run = run_program(
        "tonus",
        {"export", "--archive", archive.path(), "--format", format, "--out", (out / format).string()},
        folder_.path(), "umask 000; \"$@\"");
    EXPECT_EQ(run.code, 0) << run.errors;
  }
  EXPECT_EQ(open_to_others(out), "");
}

}  // namespace
}  // namespace tonus::testing
