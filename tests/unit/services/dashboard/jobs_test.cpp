#include "services/dashboard/gateway/jobs.hpp"

#include <fstream>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "services/core/text_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::dashboard {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr std::chrono::seconds kLimit{20};
const std::string kSession = "5a5b5c5d5e5f606162636465666768aa";

/// Jobs of a program that is a script with these lines.
class Bench {
 public:
  explicit Bench(const std::string& script) {
    const fs::path program = folder_ / "tonus";
    std::ofstream(program) << "#!/bin/sh\n" << script;
    fs::permissions(program, fs::perms::owner_all);
    jobs.emplace(JobFolders{program, "archive.sqlite", exports(), folder_ / "reports"});
  }

  [[nodiscard]] fs::path exports() const { return folder_ / "exports"; }
  [[nodiscard]] fs::path operator/(const std::string& name) const { return folder_ / name; }

  /// The job once it has ended.
  [[nodiscard]] Job ended(std::uint64_t number) const {
    return until([&] {
      const Job job = jobs->list().at(number - 1);
      return std::pair(job.state == JobState::kDone || job.state == JobState::kFailed, job);
    });
  }
  template <typename Look>
  [[nodiscard]] static Job until(const Look& look) {
    const auto deadline = std::chrono::steady_clock::now() + kLimit;
    while (true) {
      const auto [is_so, job] = look();
      if (is_so || std::chrono::steady_clock::now() > deadline) return job;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }

 private:
  testing::TemporaryFolder folder_;

 public:
  std::optional<Jobs> jobs;
};

/// Writes its arguments to what stands after --out.
constexpr char kWritesAFile[] = R"(all="$*"
while [ "$1" != --out ]; do shift; done
echo "trials: 4 of 40 "
echo "$all" > "$2"
)";

TEST(Jobs, ProgressIsReadFromTheProgramsLines) {
  EXPECT_EQ(progress_in("trials: 3 of 40 "), std::pair(std::uint64_t{3}, std::uint64_t{40}));
  EXPECT_EQ(progress_in("subjects: 2 of 11 identified"), std::pair(std::uint64_t{2}, std::uint64_t{11}));
  for (const char* other : {"writing figure3.svg", "left out: 3 of them", "trials: x of 4", "trials: 3 of"})
    EXPECT_EQ(progress_in(other), std::nullopt) << other;
}

TEST(Jobs, AnExportIsMadeByTheProgramAndKept) {
  Bench bench(kWritesAFile);
  const auto number = bench.jobs->order_export(kSession, "hdf5");
  ASSERT_TRUE(number) << number.error().message;
  const Job job = bench.ended(*number);
  EXPECT_EQ(job.state, JobState::kDone) << job.message;
  EXPECT_EQ(job.path, "/exports/tonus-5a5b5c5d-hdf5.h5");
  EXPECT_EQ(job.done, 40U);
  EXPECT_EQ(job.total, 40U);
  const auto words = read_text_file(bench.exports() / "tonus-5a5b5c5d-hdf5.h5");
  ASSERT_TRUE(words);
  EXPECT_THAT(*words, HasSubstr("export " + kSession + " --archive archive.sqlite --format hdf5 --out "));
  EXPECT_EQ(std::distance(fs::directory_iterator(bench.exports()), {}), 1) << "no scratch is left";
}

TEST(Jobs, AFolderBecomesATarFile) {
  Bench bench(R"(while [ "$1" != --out ]; do shift; done
mkdir "$2" && echo '{}' > "$2/dataset_description.json"
)");
  const auto number = bench.jobs->order_export(kSession, "bids");
  ASSERT_TRUE(number);
  const Job job = bench.ended(*number);
  EXPECT_EQ(job.state, JobState::kDone) << job.message;
  const auto tar = read_text_file(bench.exports() / "tonus-5a5b5c5d-bids.tar");
  ASSERT_TRUE(tar);
  EXPECT_THAT(*tar, HasSubstr("tonus-5a5b5c5d-bids/dataset_description.json"));
}

TEST(Jobs, AFailureSaysWhyAndKeepsTheOlderExport) {
  Bench bench("echo 'trials: 1 of 40'\necho 'tonus export: the disk is full' >&2\nexit 1\n");
  fs::create_directories(bench.exports());
  std::ofstream(bench.exports() / "tonus-5a5b5c5d-hdf5.h5") << "older";
  const auto number = bench.jobs->order_export(kSession, "hdf5");
  ASSERT_TRUE(number);
  const Job job = bench.ended(*number);
  EXPECT_EQ(job.state, JobState::kFailed);
  EXPECT_EQ(job.message, "tonus export: the disk is full");
  EXPECT_EQ(job.path, "");
  EXPECT_EQ(read_text_file(bench.exports() / "tonus-5a5b5c5d-hdf5.h5").value(), "older");
}

TEST(Jobs, AReportIsMadeOfTheCohortThatIsGiven) {
  Bench bench(R"(all="$*"
while [ "$1" != --cohort ]; do shift; done
cohort="$2"
while [ "$1" != --out ]; do shift; done
mkdir "$2" && cat "$cohort" > "$2/index.html"
)");
  const auto number = bench.jobs->order_report("pilot", "subjects");
  ASSERT_TRUE(number) << number.error().message;
  const Job job = bench.ended(*number);
  EXPECT_EQ(job.state, JobState::kDone) << job.message;
  EXPECT_EQ(job.path, "/reports/pilot/index.html");
  EXPECT_EQ(read_text_file(bench / "reports" / "pilot" / "index.html").value(), "subjects");
  const auto again = bench.jobs->order_report("pilot", "subjects");
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::kAlreadyExists);
}

TEST(Jobs, WhatIsNoNameFormatOrSessionIsRefused) {
  Bench bench("exit 0\n");
  EXPECT_THAT(bench.jobs->order_export(kSession, "pdf").error().message, HasSubstr("'pdf' is not allowed"));
  EXPECT_THAT(bench.jobs->order_export("../x", "csv").error().message, HasSubstr("session"));
  EXPECT_THAT(bench.jobs->order_report("../x", "").error().message, HasSubstr("'../x' is not allowed"));
  EXPECT_TRUE(bench.jobs->list().empty());
}

TEST(Jobs, OneThatIsUnderWayEndsWithTheGateway) {
  Bench bench("echo 'trials: 1 of 40'\nexec sleep 600\n");
  const auto number = bench.jobs->order_export(kSession, "csv");
  ASSERT_TRUE(number);
  const auto twice = bench.jobs->order_export(kSession, "csv");
  ASSERT_FALSE(twice) << "it is being made already";
  const Job job = Bench::until([&] {
    const Job now = bench.jobs->list().front();
    return std::pair(now.total == 40, now);
  });
  EXPECT_EQ(job.state, JobState::kRunning);
  bench.jobs.reset();
  EXPECT_TRUE(fs::is_empty(bench.exports()));
}

}  // namespace
}  // namespace tonus::dashboard
