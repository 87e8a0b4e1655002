#include <algorithm>
#include <csignal>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <sstream>

#include "services/core/text_file.hpp"
#include "services/store/open_store.hpp"
#include "services/store/session_reader.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kLimit{240};

std::string protocol(const std::string& name) {
  return source_file("deploy/protocols/" + name + ".toml").string();
}

/// Two subjects of the study's cohort, one of them also under bias forces; `cohort` is a file's text.
class SmallStudy {
 public:
  explicit SmallStudy(const std::string& cohort) {
    write("cohort.toml", cohort);
    write("study.toml",
          "schema = 1\nkind = \"study\"\nname = \"two\"\n[[subject]]\nname = \"s01\"\nunloaded = \"" +
              protocol("unloaded") + "\"\nloaded = \"" + protocol("loaded") +
              "\"\nseed = 1\n[[subject]]\nname = \"s02\"\nunloaded = \"" + protocol("unloaded") +
              "\"\nseed = 2\n");
    run({"demo", (folder_ / "study.toml").string(), "--cohort", cohort_file(), "--data",
         (folder_ / "data").string(), "--domain", std::to_string(own_domain())});
  }

  void report(const std::string& name) {
    run({"report", "--archive", (folder_ / "data" / "archive.sqlite").string(), "--cohort", cohort_file(),
         "--out", (folder_ / name).string()});
  }
  [[nodiscard]] std::filesystem::path path(const std::string& name) const { return folder_ / name; }

  /// Last column of the row of a table that begins with `first`.
  [[nodiscard]] std::string cell(const std::string& report, const std::string& table,
                                 const std::string& first) const {
    std::ifstream file(folder_ / report / (table + ".csv"));
    std::string line;
    while (std::getline(file, line)) {
      if (line.rfind(first, 0) == 0 || line.rfind("\"" + first, 0) == 0) return line;
    }
    return {};
  }

 private:
  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }
  [[nodiscard]] std::string cohort_file() const { return (folder_ / "cohort.toml").string(); }
  void run(const std::vector<std::string>& arguments) {
    Process process(program("tonus"), arguments, folder_ / "output");
    EXPECT_EQ(process.wait(kLimit), 0) << process.output();
  }

  TemporaryFolder folder_;
};

std::string study_cohort() {
  const auto text = read_text_file(source_file("deploy/profiles/cohort.toml"));
  return text ? *text : std::string();
}

/// One time constant for all of the damping, and a stiffness that grows with the force held.
constexpr const char* kWithoutFindings = R"(
[common.subject]
recentring = { is_on = true }
modulation = { is_on = true, gain_per_N = 0.6 }
[[subject]]
name = "s01"
damping_time_s = { shoulder = 0.05, elbow = 0.05, two_joint = 0.05 }
[[subject]]
name = "s02"
link_masses_kg = [2.2, 1.6]
damping_time_s = { shoulder = 0.06, elbow = 0.06, two_joint = 0.06 }
)";

bool has_gnuplot() { return find_program("gnuplot").has_value(); }

TEST(StudySubject, IsMeasuredSessionBySessionOnServicesThatAreUp) {
  const TemporaryFolder folder;
  std::ofstream(folder / "study.toml")
      << "schema = 1\nkind = \"study\"\nname = \"two\"\n[[subject]]\nname = \"s01\"\nunloaded = \""
      << protocol("unloaded") << "\"\nseed = 1\n[[subject]]\nname = \"s02\"\nunloaded = \""
      << protocol("unloaded") << "\"\nloaded = \"" << protocol("loaded") << "\"\nseed = 7\n";
  const auto domain = std::to_string(own_domain());
  Process system(program("tonus"),
                 {"up", "--speed", "max", "--resume-unattended", "--domain", domain, "--data",
                  folder / "data", "--profile", source_file("deploy/profiles/holding.toml").string()},
                 folder / "up");
  ASSERT_TRUE(system.wait_for_output("ready", kLimit)) << system.output();
  Process run(program("tonus"), {"run", folder / "study.toml", "--subject", "s02", "--domain", domain},
              folder / "run");
  ASSERT_EQ(run.wait(kLimit), 0) << run.output();
  system.signal(SIGTERM);
  EXPECT_EQ(system.wait(kLimit), 0) << system.output();

  auto store = store::open_store_for_reading(folder / "data" / "archive.sqlite");
  ASSERT_TRUE(store) << store.error().message;
  const auto sessions = (*store)->sessions();
  ASSERT_TRUE(sessions) << sessions.error().message;
  std::vector<std::string> kinds;
  for (const auto& record : *sessions) {
    const auto session = store::read_session(**store, record.session);
    ASSERT_TRUE(session) << session.error().message;
    ASSERT_TRUE(session->state);
    EXPECT_EQ(session->state->phase(), v1::SESSION_COMPLETED);
    EXPECT_EQ(record.subject, "s02");
    EXPECT_EQ(record.seed, 7U);
    kinds.push_back(record.protocol_name);
  }
  EXPECT_EQ(kinds, (std::vector<std::string>{"unloaded", "loaded"}));
}

TEST(StudyReport, HasEveryTableAndFigureAndIsTheSameToTheByte) {
  if (!has_gnuplot()) GTEST_SKIP() << "gnuplot is not installed (package gnuplot-nox)";
  SmallStudy study(study_cohort());
  study.report("one");
  study.report("two");
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(study.path("one"))) {
    const auto first = read_text_file(entry.path());
    const auto second = read_text_file(study.path("two") / entry.path().filename());
    ASSERT_TRUE(first && second) << entry.path();
    EXPECT_EQ(*first, *second) << entry.path();
    EXPECT_FALSE(first->empty()) << entry.path();
    ++files;
  }
  const auto page = read_text_file(study.path("one") / "index.html");
  ASSERT_TRUE(page);
  for (const char* id :
       {"table1", "table2", "table3", "table4", "figure3", "figure4", "figure5", "figure6", "figure7",
        "figure8", "figure9", "figure10", "convergence", "coverage", "intervals", "worth", "spread"}) {
    EXPECT_NE(page->find(std::string("id=\"") + id + "\""), std::string::npos) << id;
  }
  for (const char* figure : {"figure3", "figure7", "figure10"}) {
    for (const char* extension : {".svg", ".pdf", ".gp"})
      EXPECT_TRUE(std::filesystem::exists(study.path("one") / (std::string(figure) + extension)));
  }
  EXPECT_GE(files, 40U);

  // The findings that the cohort was built to have.
  EXPECT_NE(study.cell("one", "patterns", "three constants lower").find("100 % (2 of 2)"), std::string::npos);
  EXPECT_EQ(study.cell("one", "spread", "I,").substr(0, 7), "I,12,12") << study.cell("one", "spread", "I,");
  EXPECT_EQ(study.cell("one", "spread", "III,").substr(0, 7), "III,4,4")
      << study.cell("one", "spread", "III,");
  EXPECT_EQ(study.cell("one", "spread", "IV,").substr(0, 8), "IV,12,12")
      << study.cell("one", "spread", "IV,");
  const std::string smallest = study.cell("one", "patterns", "the two-joint constant is the smallest");
  EXPECT_NE(smallest.find("50 % (1 of 2)"), std::string::npos)
      << smallest;  // s01's elbow: 0.040 against 0.039
  const std::string moved = study.cell("one", "patterns", "loaded spring centre: actual over");
  EXPECT_NE(moved.find("mean 1.0"), std::string::npos) << moved;
}

TEST(StudyReport, DoesNotFindWhatACohortDoesNotHave) {
  if (!has_gnuplot()) GTEST_SKIP() << "gnuplot is not installed (package gnuplot-nox)";
  SmallStudy study(kWithoutFindings);
  study.report("one");
  for (const char* finding : {"three constants lower", "the two-joint constant is the smallest"}) {
    const std::string row = study.cell("one", "patterns", finding);
    EXPECT_NE(row.find("0 % (0 of 2)"), std::string::npos) << row;
  }
  // A stiffness 1.5 times as large: centres at two thirds of the predicted distance.
  const std::string moved = study.cell("one", "patterns", "loaded spring centre: actual over");
  EXPECT_NE(moved.find("mean 0.6"), std::string::npos) << moved;
}

}  // namespace
}  // namespace tonus::testing
