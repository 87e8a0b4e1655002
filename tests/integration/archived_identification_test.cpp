// `tonus identify` of an archive gives the numbers that the streaming service published.
#include <fstream>
#include <gtest/gtest.h>

#include "services/store/open_store.hpp"
#include "services/store/session_reader.hpp"
#include "tests/integration/demo_run.hpp"

namespace tonus::testing {
namespace {

/// Two postures with one set of eight each: a session of a second.
const char* const kShortProtocol = R"(
schema = 1
kind = "unloaded"
name = "short"
shoulder_angle_rad = 0.0
confirm_posture = false
rejection_limit = 8

[[posture]]
name = "reference"
position_m = [0.000, 0.380]

[[posture]]
name = "left"
position_m = [-0.295, 0.380]

[perturbation]
directions = 8
first_direction_deg = 0.0
sets = 1
amplitude_m = 0.005
rise_time_s = 0.2
hold_s = [1.5, 2.0]
wait_s = [3.0, 5.0]
end_rest_s = 0.2

[cue]
target_circle_diameter_m = 0.010
shows_cursor = true
text = "Hold still."
)";

class ArchivedSession : public ::testing::Test {
 protected:
  static constexpr std::chrono::seconds kLimit{60};

  void SetUp() override {
    const auto protocol = folder_ / "short.toml";
    std::ofstream(protocol) << kShortProtocol;
    live_ = std::make_unique<DemoRun>(std::vector<std::string>{
        protocol.string(), "--profile", source_file("deploy/profiles/default.toml").string()});
    ASSERT_EQ(live_->finish(), 0) << live_->everything_printed();
  }

  [[nodiscard]] std::filesystem::path data() const { return live_->folder() / "data"; }

  /// The conditions that `tonus identify` writes for these arguments.
  nlohmann::json identify(std::vector<std::string> arguments) {
    const auto json = folder_ / "identified.json";
    arguments.insert(arguments.begin(), "identify");
    arguments.insert(arguments.end(), {"--json", json.string()});
    Process process(program("tonus"), arguments, folder_ / "identify.txt");
    EXPECT_EQ(process.wait(kLimit), 0) << process.output();
    std::ifstream file(json);
    return nlohmann::json::parse(file, nullptr, false).at("conditions");
  }

  /// Exit code and output of a call that is to be refused.
  std::pair<int, std::string> refused(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "identify");
    Process process(program("tonus"), arguments, folder_ / "refused.txt");
    const int code = process.wait(kLimit);
    return {code, process.output()};
  }

  TemporaryFolder folder_;
  std::unique_ptr<DemoRun> live_;
};

TEST_F(ArchivedSession, GivesThePublishedNumbersToTheLastBit) {
  auto store = store::open_store_for_reading((data() / "archive.sqlite").string());
  ASSERT_TRUE(store) << store.error().message;
  const auto record = store::find_session(**store, "");
  ASSERT_TRUE(record) << record.error().message;
  const auto session = store::read_session(**store, record->session);
  ASSERT_TRUE(session) << session.error().message;
  const auto published = store::newest_estimates(*session);
  ASSERT_EQ(published.size(), 2U);

  for (const auto& source : {data(), data() / "archive.sqlite"}) {
    const auto conditions = identify({source.string()});

    ASSERT_EQ(conditions.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
      const auto& found = conditions[i];
      const auto& live = published[i];
      EXPECT_EQ(found.at("posture"), live.posture());
      EXPECT_EQ(found.at("status"), "ok");
      EXPECT_EQ(found.at("trials_used"), live.trials_used());
      EXPECT_EQ(found.at("samples"), live.samples());
      const auto same = [&](const char* key, const v1::MatrixEstimate& matrix) {
        for (std::size_t k = 0; k < 4; ++k) {
          EXPECT_EQ(found.at(key).at(k / 2).at(k % 2).get<double>(), matrix.value()[k]) << key << " " << k;
          EXPECT_EQ(found.at("std").at(key).at(k / 2).at(k % 2).get<double>(), matrix.standard_error()[k]);
        }
      };
      same("M_kg", live.mass_kg());
      same("B_Ns_per_m", live.damping_Ns_per_m());
      same("K_N_per_m", live.stiffness_N_per_m());
      EXPECT_EQ(found.at("condition_number").get<double>(), live.condition_number());
    }
  }
}

TEST_F(ArchivedSession, IsFoundByItsIdAndAnalysedByEveryMethod) {
  auto store = store::open_store_for_reading((data() / "archive.sqlite").string());
  ASSERT_TRUE(store) << store.error().message;
  const std::string id = to_hex(store::find_session(**store, "").value().session);

  const auto conditions =
      identify({data().string(), "--session", id.substr(0, 8), "--method", "all", "--model", "no_damping"});

  ASSERT_EQ(conditions.size(), 6U);
  EXPECT_EQ(conditions[0].at("session"), id);
  const auto [code, text] = refused({data().string(), "--session", "ffffffffffffffff"});
  EXPECT_NE(code, 0);
  EXPECT_NE(text.find(id), std::string::npos) << text;  // lists the sessions that there are
}

}  // namespace
}  // namespace tonus::testing
