#include <gtest/gtest.h>

#include "tests/integration/demo_run.hpp"

namespace tonus::testing {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds kLimit{120};

/// What `tonus` prints on standard output, as JSON: the progress on standard error comes before it.
nlohmann::json json_of(const std::string& output) {
  const auto at = output.find("{\n");
  return at == std::string::npos ? nlohmann::json()
                                 : nlohmann::json::parse(output.substr(at), nullptr, false);
}

class ArchivedSession : public ::testing::Test {
 protected:
  int run_tonus(const std::vector<std::string>& arguments) {
    Process process(program("tonus"), arguments, folder_ / "output");
    const int code = process.wait(kLimit);
    output_ = process.output();
    return code;
  }

  TemporaryFolder folder_;
  std::string output_;
};

/// The estimates of two sessions, by posture and method: every number the same as printed in full.
void expect_same_numbers(const nlohmann::json& a, const nlohmann::json& b) {
  ASSERT_EQ(a.at("conditions").size(), b.at("conditions").size());
  for (const auto& x : a.at("conditions")) {
    const auto& all = b.at("conditions");
    const auto same = std::find_if(all.begin(), all.end(), [&](const auto& c) {
      return c.at("posture") == x.at("posture") && c.at("method") == x.at("method");
    });
    ASSERT_NE(same, all.end()) << x.at("posture");
    const auto& y = *same;
    for (const char* key : {"posture", "method", "trials_used", "samples", "M_kg", "B_Ns_per_m", "K_N_per_m",
                            "X0_m", "std", "ci95", "sigma_N", "condition_number"}) {
      EXPECT_EQ(x.at(key), y.at(key)) << x.at("posture") << " " << key;
    }
  }
}

TEST_F(ArchivedSession, IsVerifiedShownExportedAndImportedWithTheSameNumbers) {
  DemoRun demo({source_file("deploy/protocols/unloaded.toml").string(), "--profile",
                source_file("deploy/profiles/default.toml").string()});
  ASSERT_EQ(demo.finish(), 0) << demo.everything_printed();
  const std::string archive = (demo.folder() / "data" / "archive.sqlite").string();

  EXPECT_EQ(run_tonus({"ls", "--archive", archive, "--json"}), 0) << output_;
  const auto listed = json_of(output_).at("sessions");
  ASSERT_EQ(listed.size(), 1U);
  EXPECT_EQ(listed[0].at("state"), "completed");
  EXPECT_EQ(listed[0].at("counted"), 80);
  EXPECT_EQ(listed[0].at("samples").at("missing"), 0);
  const std::string session = listed[0].at("session");

  // Bit for bit what was published, from the raw data.
  EXPECT_EQ(run_tonus({"verify", session.substr(0, 6), "--archive", archive, "--json"}), 0) << output_;
  const auto verified = json_of(output_);
  EXPECT_EQ(verified.at("problems"), nlohmann::json::array());
  ASSERT_EQ(verified.at("conditions").size(), 5U);
  for (const auto& condition : verified.at("conditions"))
    EXPECT_EQ(condition.at("outcome"), "equal") << condition;

  EXPECT_EQ(run_tonus({"show", "--archive", archive, "--json"}), 0) << output_;
  const auto shown = json_of(output_);
  expect_same_numbers(shown, demo.results());

  const std::string dataset = (folder_ / "dataset").string();
  const std::string other = (folder_ / "other.sqlite").string();
  EXPECT_EQ(run_tonus({"export", "--archive", archive, "--format", "bids", "--out", dataset}), 0) << output_;
  EXPECT_EQ(run_tonus({"import", dataset, "--archive", other}), 0) << output_;
  EXPECT_EQ(run_tonus({"verify", "--archive", other}), 0) << output_;
  EXPECT_EQ(run_tonus({"show", "--archive", other, "--json"}), 0) << output_;
  expect_same_numbers(json_of(output_), shown);
}

TEST_F(ArchivedSession, MayBeReadWhileItIsRun) {
  DemoRun demo({source_file("deploy/protocols/unloaded.toml").string(), "--profile",
                source_file("deploy/profiles/default.toml").string(), "--speed", "real"});
  ASSERT_TRUE(demo.process().wait_for_output("session ", kLimit)) << demo.everything_printed();
  const std::string archive = (demo.folder() / "data" / "archive.sqlite").string();
  const auto deadline = std::chrono::steady_clock::now() + kLimit;
  std::size_t trials = 0;
  while (trials == 0 && std::chrono::steady_clock::now() < deadline) {
    if (run_tonus({"ls", "--archive", archive, "--json"}) != 0) continue;
    const auto listed = json_of(output_).at("sessions");
    if (!listed.empty()) trials = listed[0].at("attempts");
  }
  EXPECT_GT(trials, 0U) << output_;
  EXPECT_EQ(run_tonus({"verify", "--archive", archive, "--json"}), 0) << output_;
  EXPECT_EQ(json_of(output_).at("is_over"), false);
}

TEST_F(ArchivedSession, NamesASessionThatIsNotThere) {
  EXPECT_EQ(run_tonus({"verify", "abc", "--archive", (folder_ / "none.sqlite").string()}), 1);
  EXPECT_NE(output_.find("none.sqlite"), std::string::npos) << output_;
}

}  // namespace
}  // namespace tonus::testing
