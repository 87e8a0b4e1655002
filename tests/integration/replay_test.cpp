#include <cstdlib>
#include <gtest/gtest.h>

#include "tests/integration/demo_run.hpp"

namespace tonus::testing {
namespace {

/// The five measured ankle records (reklab/reklab_public, experimental_data.mat), with the settings that the
/// state-variable filter needs for a continuous broadband perturbation: natural frequency 30 Hz, damping
/// ratio 0.1.
TEST(AnkleReplay, HasTheInertiaAndTheOrderOfStiffnessesOfTheRecords) {
  const char* data = std::getenv("TONUS_DATA_DIR");
  if (data == nullptr || !std::filesystem::is_directory(std::filesystem::path(data) / "ankle")) {
    GTEST_SKIP() << "TONUS_DATA_DIR names no folder with the measured ankle records";
  }
  DemoRun run({"--dataset", (std::filesystem::path(data) / "ankle").string(), "--force-sign", "-1",
               "--method", "state_variable", "--natural-frequency", "30", "--damping-ratio", "0.1"});
  ASSERT_EQ(run.finish(), 0) << run.everything_printed();
  const auto results = run.results();
  const auto& conditions = results.at("conditions");
  ASSERT_EQ(conditions.size(), 5U);
  std::vector<double> stiffness;
  for (const auto& condition : conditions) {
    const double inertia = condition.at("M_kg").at(0).at(0);
    EXPECT_GT(inertia, 0.014) << condition.at("posture");
    EXPECT_LT(inertia, 0.021) << condition.at("posture");
    stiffness.push_back(condition.at("K_N_per_m").at(0).at(0));
  }
  // Runs 1 to 5 are z_df, z_pf, z_df2, z_df3, z_pf2.
  EXPECT_LT(stiffness[2], stiffness[0]);
  EXPECT_LT(stiffness[0], stiffness[3]);
  EXPECT_LT(stiffness[1], stiffness[4]);
}

/// Without any setting: band and lag come from the data, and the delayed reflex, which a second-order model
/// does not have, makes every record suspect.
TEST(AnkleReplay, HasTheInertiaOfTheRecordsWithoutAnyTuningAndSaysWhatDoesNotFit) {
  const char* data = std::getenv("TONUS_DATA_DIR");
  if (data == nullptr || !std::filesystem::is_directory(std::filesystem::path(data) / "ankle")) {
    GTEST_SKIP() << "TONUS_DATA_DIR names no folder with the measured ankle records";
  }
  DemoRun run({"--dataset", (std::filesystem::path(data) / "ankle").string(), "--force-sign", "-1"});
  ASSERT_EQ(run.finish(), 0) << run.everything_printed();
  const auto results = run.results();
  const auto& conditions = results.at("conditions");
  ASSERT_EQ(conditions.size(), 5U);
  for (const auto& condition : conditions) {
    EXPECT_EQ(condition.at("method"), "spectral");
    EXPECT_EQ(condition.at("status"), "suspect");
    const double inertia = condition.at("M_kg").at(0).at(0);
    EXPECT_GT(inertia, 0.014) << condition.at("posture");
    EXPECT_LT(inertia, 0.021) << condition.at("posture");
    EXPECT_TRUE(condition.at("lag_s").at(0).is_number());
    EXPECT_GT(condition.at("band_Hz").at(1).get<double>(), condition.at("band_Hz").at(0).get<double>());
  }
}

}  // namespace
}  // namespace tonus::testing
