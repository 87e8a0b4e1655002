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
  recording.auxiliary_channels = {{"Biceps", "EMG", "mV", 1.0, 2000.0}};
  for (int i = 0; i < 800; ++i) recording.auxiliary.push_back(0.5F * static_cast<float>(i));
  return recording;
}

simulation::Profile with_muscles() {
  simulation::Profile profile;
  profile.auxiliary = {{"TwoJointFlexor", "EMG", "mV", 1.0, 2000.0}, {"Onset", "TRIG", "n/a", 1.0, 200.0}};
  return profile;
}

std::unique_ptr<Driver> calibrated() {
  return std::make_unique<Calibrated>(std::make_unique<Simulated>(with_muscles()),
                                      [](const RigGeometry& geometry) { return geometry; });
}

std::unique_ptr<Driver> library(const std::string& file, const std::string& options) {
  auto loaded = Library::load(file, options);
  EXPECT_TRUE(loaded) << (loaded ? "" : loaded.error().message);
  return loaded ? std::move(*loaded) : nullptr;
}

INSTANTIATE_TEST_SUITE_P(
    AllDrivers, DriverContract,
    ::testing::Values(
        DriverCandidate{"Simulated", [] { return std::make_unique<Simulated>(simulation::Profile{}); }},
        DriverCandidate{"Replay", [] { return std::make_unique<Replay>(two_axis_recording()); }},
        DriverCandidate{"Calibrated", calibrated},
        DriverCandidate{"SimulatedWithMuscles", [] { return std::make_unique<Simulated>(with_muscles()); }},
        DriverCandidate{"Library", [] { return library(TONUS_SPRING_RIG, ""); }},
        DriverCandidate{"LibraryWithAuxiliaryChannels",
                        [] { return library(TONUS_SPRING_RIG, "auxiliary=on"); }},
        DriverCandidate{"LibraryOfVersion1", [] { return library(TONUS_FIRST_DRIVER, "auxiliary=on"); }},
        DriverCandidate{"FirstLibraryOfVersion2",
                        [] { return library(TONUS_SECOND_DRIVER, "auxiliary=on"); }}),
    [](const auto& candidate) { return candidate.param.name; });

}  // namespace
}  // namespace tonus::drivers
