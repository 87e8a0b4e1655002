#include "tests/unit/rig_agent/drivers/driver_contract.hpp"

#include "rig_agent/drivers/calibrated.hpp"
#include "rig_agent/drivers/library.hpp"
#include "rig_agent/drivers/replay.hpp"
#include "rig_agent/drivers/simulated.hpp"

namespace tonus::drivers {
namespace {

Recording two_axis_recording() {
  Recording recording;
  recording.rate = 1000.0;
  for (int i = 0; i < 400; ++i) {
    RecordedRow row;
    row.raw.acquisition_ns = 77'000'000 + i * 1'000'000;
    row.raw.encoder_count = {100.0 + i, 2000.0 - i};
    row.raw.force_V = {0.01 * i, -0.01 * i};
    recording.rows.push_back(row);
  }
  recording.segments = {{0, 50, 199}, {200, 250, 399}};
  return recording;
}

std::unique_ptr<Driver> calibrated() {
  return std::make_unique<Calibrated>(std::make_unique<Simulated>(simulation::Profile{}),
                                      [](const RigGeometry& geometry) { return geometry; });
}

std::unique_ptr<Driver> library() {
  auto loaded = Library::load(TONUS_SPRING_RIG, "");
  EXPECT_TRUE(loaded) << (loaded ? "" : loaded.error().message);
  return loaded ? std::move(*loaded) : nullptr;
}

INSTANTIATE_TEST_SUITE_P(
    AllDrivers, DriverContract,
    ::testing::Values(
        DriverCandidate{"Simulated", [] { return std::make_unique<Simulated>(simulation::Profile{}); }},
        DriverCandidate{"Replay", [] { return std::make_unique<Replay>(two_axis_recording()); }},
        DriverCandidate{"Calibrated", calibrated}, DriverCandidate{"Library", library}),
    [](const auto& candidate) { return candidate.param.name; });

}  // namespace
}  // namespace tonus::drivers
