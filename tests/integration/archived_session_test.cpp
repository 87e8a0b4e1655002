#include <fstream>
#include <gtest/gtest.h>
#include <signal.h>

#include "services/core/text_file.hpp"
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

/// Trials rejected by hand while the session goes on, with its scheduler and then its identification killed.
TEST_F(ArchivedSession, WithTrialsRejectedByHandHasTheEstimatesWithoutThemToTheLastBit) {
  // The session waits for the operator at each posture, and so for this test.
  const auto protocol = folder_ / "protocol.toml";
  std::string text = read_text_file(source_file("deploy/protocols/unloaded.toml")).value();
  const std::string kGoesOn = "confirm_posture = false";
  ASSERT_NE(text.find(kGoesOn), std::string::npos);
  std::ofstream(protocol) << text.replace(text.find(kGoesOn), kGoesOn.size(), "confirm_posture = true");
  DemoRun demo({protocol.string(), "--profile", source_file("deploy/profiles/default.toml").string()});
  ASSERT_TRUE(demo.process().wait_for_output("posture 'reference'", kLimit)) << demo.everything_printed();
  const std::string domain = std::to_string(own_domain());
  const std::string data = (demo.folder() / "data").string();
  const auto resume = [&] { return run_tonus({"resume", "--domain", domain, "--data", data}); };
  const auto ask = [&](std::vector<std::string> words) {
    words.insert(words.end(), {"--domain", domain, "--data", data, "--by", "Ada"});
    return run_tonus(words);
  };
  ASSERT_EQ(resume(), 0) << output_;
  ASSERT_TRUE(demo.process().wait_for_output("posture 'distal'", kLimit)) << demo.everything_printed();
  ASSERT_EQ(ask({"reject", "3", "--because", "coughed"}), 0) << output_;
  EXPECT_NE(output_.find("trial 3 is left out and runs again"), std::string::npos) << output_;
  const pid_t scheduler = child_named(demo.process().id(), "tonus-scheduler");
  ASSERT_NE(scheduler, 0);
  ASSERT_EQ(kill(scheduler, SIGKILL), 0);
  // Until the scheduler is back nobody knows of a session.
  const auto deadline = std::chrono::steady_clock::now() + kLimit;
  while (ask({"note", "the subject coughed", "--trial", "3"}) != 0 &&
         std::chrono::steady_clock::now() < deadline) {
  }
  EXPECT_NE(ask({"reject", "3", "--because", "again"}), 0);
  EXPECT_NE(output_.find("trial 3 was rejected by hand already by Ada: coughed"), std::string::npos)
      << output_;
  ASSERT_EQ(ask({"reject", "5", "--because", "slipped"}), 0) << output_;
  const pid_t identification = child_named(demo.process().id(), "tonus-identification");
  ASSERT_NE(identification, 0);
  ASSERT_EQ(kill(identification, SIGKILL), 0);
  const auto limit = std::chrono::steady_clock::now() + 2 * kLimit;
  while (demo.process().wait(std::chrono::milliseconds(100)) == Process::kStillRunning &&
         std::chrono::steady_clock::now() < limit)
    (void)resume();
  ASSERT_EQ(demo.finish(), 0) << demo.everything_printed();

  const store::Session session = demo.archived();
  EXPECT_EQ(session.state->counted(), 80U);
  EXPECT_GE(session.trials.size(), 82U);
  ASSERT_EQ(session.notes.size(), 1U);
  EXPECT_EQ(store::attempt_of(session, session.notes[0].value), 3U);
  EXPECT_EQ(store::why_not_counted(session.trials.at(2)), "rejected by hand by Ada: coughed");
  EXPECT_EQ(store::why_not_counted(session.trials.at(4)), "rejected by hand by Ada: slipped");
  for (const auto& estimate : store::newest_estimates(session)) {
    for (const auto& trial : estimate.trials()) EXPECT_TRUE(trial.attempt() != 3 && trial.attempt() != 5);
  }

  const std::string archive = (demo.folder() / "data" / "archive.sqlite").string();
  EXPECT_EQ(run_tonus({"verify", "--archive", archive, "--json"}), 0) << output_;
  const auto verified = json_of(output_);
  ASSERT_EQ(verified.at("conditions").size(), 5U);
  for (const auto& condition : verified.at("conditions"))
    EXPECT_EQ(condition.at("outcome"), "equal") << condition;
  EXPECT_EQ(run_tonus({"identify", archive, "--json", (folder_ / "again.json").string()}), 0) << output_;
  std::ifstream again(folder_ / "again.json");
  expect_same_numbers(nlohmann::json::parse(again, nullptr, false), demo.results());
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
