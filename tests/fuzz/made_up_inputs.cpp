#include <cmath>

#include "idl/topics.hpp"
#include "services/archive/ingest.hpp"
#include "services/archive/wire.hpp"
#include "services/core/crc32c.hpp"
#include "services/recording/dataset.hpp"
#include "services/store/sqlite_store.hpp"
#include "tests/fault/archive/made_up_rig.hpp"
#include "tests/fuzz/target.hpp"

namespace tonus::fuzz {

Result<void> check_message(const std::string& message) {
  if (!message.empty() && message.find('\n') == std::string::npos) return {};
  return fail(ErrorCode::kInternal, "a message that is not one line: '" + message + "'");
}

Result<void> make_store(const std::string& path) {
  auto store = store::SqliteStore::open(path, store::SqliteStore::Access::kWrite);
  if (!store) return store.error();
  const ManualClock clock;
  archive::Ingest ingest(**store, clock);
  if (auto recovered = ingest.recover(); !recovered) return recovered;
  archive::testing::MadeUpRig rig(1);
  const auto give = [&ingest](const auto& topic, const auto& value) {
    bus::Sample sample;
    sample.payload = std::make_shared<const bus::Payload>(*bus::encode(value));
    static_cast<void>(archive::feed(ingest, topic.spec, sample, 1));
  };
  v1::SessionPlan plan;
  plan.session_id(archive::testing::MadeUpRig::session());
  plan.subject("s01");
  plan.started_at("2026-03-01T10:00:00Z");
  give(topics::kSessionPlan, plan);
  for (int i = 0; i < 2; ++i) {
    const auto trial = rig.next_trial();
    for (std::uint64_t first = trial.range.first; first < trial.range.end; first += 100)
      give(topics::kRigSamples, rig.block(first, 100, false));
    give(topics::kTrialOutcome, rig.outcome(trial));
  }
  static_cast<void>(ingest.step());
  v1::SessionState state;
  state.session_id(plan.session_id());
  state.phase(v1::SESSION_COMPLETED);
  give(topics::kSessionState, state);
  return ingest.finish();
}

Result<void> make_dataset(const std::filesystem::path& root) {
  recording::Recording run;
  run.participant.id = "sub-01";
  run.participant.upper_arm_m = 0.31;
  run.session = "ses-01";
  run.task = "unloaded";
  run.sampling_frequency = 200;
  run.is_raw = true;
  run.posture = "left";
  run.posture_position = Eigen::Vector2d(-0.295, 0.38);
  for (std::size_t i = 0; i < 60; ++i) {
    recording::Row row;
    row.raw.acquisition_ns = recording::row_time_ns(run, i);
    row.raw.encoder_count = {static_cast<double>(i * 3), -static_cast<double>(i)};
    row.raw.force_V = {std::sin(0.1 * static_cast<double>(i)), 0.25};
    run.rows.push_back(row);
  }
  run.commanded.assign(60, {0.005, 0.0});
  recording::PerturbationEvent event;
  event.onset_s = 0.05;
  event.duration_s = 0.2;
  event.direction_deg = 45.0;
  event.amplitude_m = 0.005;
  event.rise_time_s = 0.1;
  event.bias_N = {0.7, -0.1};
  run.events = {event};
  recording::Recording converted = run;
  converted.run = 2;
  converted.events[0].trial = 2;
  return recording::write_dataset(root, {run, converted});
}

}  // namespace tonus::fuzz
