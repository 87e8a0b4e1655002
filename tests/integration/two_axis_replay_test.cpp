#include <cmath>
#include <gtest/gtest.h>
#include <map>

#include "analysis_service/identification/wire.hpp"
#include "idl/bounds.hpp"
#include "services/archive/open_store.hpp"
#include "services/archive/sample_reader.hpp"
#include "services/bus/typed.hpp"
#include "services/recording/dataset.hpp"
#include "tests/integration/demo_run.hpp"

#include <idl/rig.h>
#include <idl/trial.h>

namespace tonus::testing {
namespace {

template <typename T>
std::vector<T> messages(archive::Store& store, const std::string& topic) {
  std::vector<T> found;
  const auto visited =
      store.visit_messages({topic, {}, {}}, [&](const archive::Message& message) -> Result<void> {
        auto value = bus::decode<T>(*message.payload);
        if (!value) return value.error();
        found.push_back(std::move(*value));
        return {};
      });
  EXPECT_TRUE(visited) << visited.error().message;
  return found;
}

void append_trial(archive::Store& store, const v1::TrialOutcome& outcome, recording::Recording& record) {
  const archive::StreamKey stream{outcome.program().rig_id(), outcome.epoch()};
  auto samples =
      archive::read_samples(store, stream, {outcome.first_sequence(), outcome.last_sequence() + 1});
  ASSERT_TRUE(samples) << samples.error().message;
  const auto& program = outcome.program();
  recording::PerturbationEvent event;
  const auto rows_before = record.rows.size() + (outcome.onset_sequence() - outcome.first_sequence());
  event.onset_s = static_cast<double>(rows_before) / record.sampling_frequency;
  event.duration_s = program.hold_s();
  event.trial = program.attempt();
  event.set = program.set_number();
  event.direction_deg = program.direction_deg();
  event.amplitude_m = program.amplitude_m();
  event.rise_time_s = program.rise_time_s();
  record.events.push_back(event);
  for (const auto& sample : *samples) {
    recording::Row row;
    row.raw.encoder_count = sample.encoder_count();
    row.raw.force_V = sample.force_V();
    record.rows.push_back(row);
    record.commanded.push_back(sample.commanded_m());
  }
}

/// The archived session as a dataset of raw counts and volts: one run for each posture.
std::vector<recording::Recording> recordings_of(archive::Store& store) {
  const auto descriptions = messages<v1::RigDescription>(store, "rig/description");
  std::map<std::uint32_t, recording::Recording> by_posture;
  std::map<std::uint32_t, v1::TrialOutcome> by_attempt;
  for (const auto& outcome : messages<v1::TrialOutcome>(store, "trial/outcome")) {
    by_attempt[outcome.program().attempt()] = outcome;
  }
  for (const auto& [attempt, outcome] : by_attempt) {
    const auto& program = outcome.program();
    auto& record = by_posture[program.posture_index()];
    record.participant.id = "sub-01";
    record.task = "unloaded";
    record.acquisition = program.posture();
    record.posture = program.posture();
    record.posture_position = Eigen::Vector2d(program.posture_m()[0], program.posture_m()[1]);
    record.run = static_cast<int>(program.posture_index()) + 1;
    record.sampling_frequency = outcome.sample_rate_Hz();
    record.is_raw = true;
    record.rig = *identification::from_wire(descriptions.at(0));
    record.shoulder = {{program.shoulder_origin_m()[0], program.shoulder_origin_m()[1]},
                       program.shoulder_angle_rad()};
    append_trial(store, outcome, record);
  }
  std::vector<recording::Recording> all;
  for (auto& [index, record] : by_posture) all.push_back(std::move(record));
  return all;
}

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
  auto store = archive::open_store_for_reading((live.folder() / "data" / "archive.sqlite").string());
  ASSERT_TRUE(store) << store.error().message;
  const auto dataset = live.folder() / "dataset";
  const auto written = recording::write_dataset(dataset, recordings_of(**store));
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
