#include <csignal>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>
#include <thread>

#include "services/formats/session_recordings.hpp"
#include "services/recording/dataset.hpp"
#include "services/store/session_reader.hpp"
#include "tests/integration/archive_file.hpp"
#include "tests/integration/program_run.hpp"
#include "tests/support/process.hpp"

namespace tonus::testing {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds kLimit{60};

class StandardStreams : public ::testing::Test {
 protected:
  /// What is open under a standard descriptor of a process.
  static std::string open_at(pid_t process, int descriptor) {
    std::error_code error;
    return fs::read_symlink(fmt::format("/proc/{}/fd/{}", process, descriptor), error);
  }

  /// Whether the service, started with the descriptors 0 to 2 closed, comes to have nothing there.
  bool has_nothing_at_its_descriptors(const std::string& name) {
    const Process service("/bin/sh",
                          {"-c", "exec \"$@\" <&- >&- 2>&-", "sh", program(name).string(), "--domain",
                           std::to_string(own_domain()), "--data", (folder_ / name).string()},
                          folder_ / "output");
    const auto deadline = std::chrono::steady_clock::now() + kLimit;
    while (std::chrono::steady_clock::now() < deadline) {
      bool is_good = true;
      for (int descriptor = 0; descriptor < 3; ++descriptor)
        is_good &= open_at(service.id(), descriptor) == "/dev/null";
      // The shell has /dev/null at 0 before it becomes the service.
      std::error_code error;
      if (is_good && fs::read_symlink(fmt::format("/proc/{}/exe", service.id()), error).filename() == name)
        return true;
      std::this_thread::yield();
    }
    return false;
  }

  /// Several sessions of the made-up one's trials, whose import takes a while.
  std::string large_dataset(store::Store& store, const Id& session) {
    const auto recordings = formats::recordings_of(store, *store::read_session(store, session));
    EXPECT_TRUE(recordings) << recordings.error().message;
    std::vector<recording::Recording> all;
    for (int i = 0; i < 30; ++i) {
      for (auto record : *recordings) {
        record.session = fmt::format("ses-{}", i);
        all.push_back(std::move(record));
      }
    }
    const auto written = recording::write_dataset(folder_ / "dataset", all);
    EXPECT_TRUE(written) << written.error().message;
    return (folder_ / "dataset").string();
  }

  TemporaryFolder folder_;
};

TEST_F(StandardStreams, ThatAreClosedAreOccupiedByEveryService) {
  for (const char* name :
       {"tonus-archive", "tonus-scheduler", "tonus-identification", "tonus-dashboard", "tonus-rig-agent"}) {
    EXPECT_TRUE(has_nothing_at_its_descriptors(name)) << name;
  }
}

TEST_F(StandardStreams, OutputOnAFullDiskIsAnErrorOfEveryCommandThatPrints) {
  const ArchiveFile archive;
  const std::string file = archive.path();
  const auto out = (folder_ / "out").string();
  const std::vector<std::vector<std::string>> commands{
      {"--help"},
      {"--version"},
      {"ls", "--archive", file},
      {"ls", "--json", "--archive", file},
      {"show", "--archive", file},
      {"show", "--json", "--archive", file},
      {"verify", "--archive", file},
      {"verify", "--json", "--archive", file},
      {"identify", file},
      {"recover", file, "--out", out + ".sqlite"},
      {"export", "--archive", file, "--format", "csv", "--out", out},
      {"run", "--dry-run", source_file("deploy/protocols/unloaded.toml").string()},
      {"run", "--dry-run", source_file("deploy/protocols/study.toml").string()},
  };
  for (const auto& command : commands) {
    const auto run = run_program("tonus", command, folder_.path(), "\"$@\" > /dev/full");
    EXPECT_GT(run.code, 0) << command[0];
    EXPECT_NE(run.errors.find("standard output cannot be written: No space left on device"),
              std::string::npos)
        << command[0] << ": " << run.errors;
  }
  for (const char* name : {"tonus-archive", "tonus-scheduler", "tonus-identification", "tonus-dashboard",
                           "tonus-rig-agent", "tonus-rig-watchdog"}) {
    const auto run = run_program(name, {"--help"}, folder_.path(), "\"$@\" > /dev/full");
    EXPECT_TRUE(is_refused_in_one_line(run)) << name << " " << run.code << ": " << run.errors;
  }
}

TEST_F(StandardStreams, InterruptedImportLeavesNoArchiveOrOneThatIsWhole) {
  auto archive = store::open_store_for_writing(":memory:");
  const auto record = made_up::put_session(**archive, made_up::unloaded_session());
  const auto dataset = large_dataset(**archive, record.session);
  const auto file = (folder_ / "imported.sqlite").string();
  Process import(program("tonus"), {"import", dataset, "--archive", file}, folder_ / "import");
  ASSERT_TRUE(import.wait_for_output("trials: ", kLimit)) << import.output();
  import.signal(SIGINT);
  EXPECT_NE(import.wait(kLimit), Process::kStillRunning);
  if (!fs::exists(file)) return;  // as it is, unless the signal came late
  const auto list = run_program("tonus", {"ls", "--archive", file}, folder_.path());
  EXPECT_EQ(list.code, 0) << list.errors;
  EXPECT_EQ(list.output.find("no session"), std::string::npos) << list.output;
}

}  // namespace
}  // namespace tonus::testing
