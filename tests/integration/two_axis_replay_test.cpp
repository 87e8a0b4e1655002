#include <cmath>
#include <gtest/gtest.h>

#include "services/formats/session_recordings.hpp"
#include "services/recording/dataset.hpp"
#include "services/store/open_store.hpp"
#include "services/store/session_reader.hpp"
#include "tests/integration/demo_run.hpp"

namespace tonus::testing {
namespace {

void expect_same_matrix(const nlohmann::json& replayed, const nlohmann::json& live, const char* name) {
  for (std::size_t row = 0; row < 2; ++row) {
    for (std::size_t column = 0; column < 2; ++column) {
      const double value = live.at(name).at(row).at(column);
      EXPECT_NEAR(replayed.at(name).at(row).at(column), value, 1e-9 * std::abs(value)) << name;
    }
  }
}

TEST(TwoAxisReplay, OfARecordedSessionGivesTheNumbersOfTheSession) {
  DemoRun live({source_file("deploy/protocols/unloaded.toml").string(), "--profile",
                source_file("deploy/profiles/default.toml").string()});
  ASSERT_EQ(live.finish(), 0) << live.everything_printed();
  auto store = store::open_store_for_reading((live.folder() / "data" / "archive.sqlite").string());
  ASSERT_TRUE(store) << store.error().message;
  const auto dataset = live.folder() / "dataset";
  const auto record = store::find_session(**store, "");
  ASSERT_TRUE(record) << record.error().message;
  const auto session = store::read_session(**store, record->session);
  ASSERT_TRUE(session) << session.error().message;
  const auto recordings = formats::recordings_of(**store, *session);
  ASSERT_TRUE(recordings) << recordings.error().message;
  const auto written = recording::write_dataset(dataset, *recordings);
  ASSERT_TRUE(written) << written.error().message;

  DemoRun replay({"--dataset", dataset.string()});

  ASSERT_EQ(replay.finish(), 0) << replay.everything_printed();
  const auto live_results = live.results();
  const auto replayed_results = replay.results();
  ASSERT_EQ(replayed_results.at("conditions").size(), 5U);
  for (const auto& original : live_results.at("conditions")) {
    const std::string posture = original.at("posture");
    bool is_found = false;
    for (const auto& again : replayed_results.at("conditions")) {
      if (again.at("posture").get<std::string>().rfind(posture, 0) != 0) continue;
      is_found = true;
      for (const char* matrix : {"M_kg", "B_Ns_per_m", "K_N_per_m"})
        expect_same_matrix(again, original, matrix);
    }
    EXPECT_TRUE(is_found) << posture;
  }
}

}  // namespace
}  // namespace tonus::testing
