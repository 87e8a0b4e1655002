#include "rig_agent/calibration/calibration.hpp"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace tonus::calibration {
namespace {

const Signature kSignature{"2026-03-01T12:00:00Z", "Ada"};

TEST(Calibration, IsEmptyWithoutAFileAndChangesNothing) {
  const testing::TemporaryFolder folder;
  const auto calibration = Calibration::load(folder / "calibration.toml", "simulated");
  ASSERT_TRUE(calibration);
  EXPECT_TRUE(calibration->text().empty());
  EXPECT_TRUE(calibration->at().empty());
  const RigGeometry geometry;
  EXPECT_EQ(calibration->applied_to(geometry).force_calibration, geometry.force_calibration);
}

TEST(Calibration, IsReadBackFromItsFileAndCorrectsTheGeometry) {
  const testing::TemporaryFolder folder;
  Calibration calibration("simulated");
  RestReading reading;
  reading.volts = {0.125, -0.0625};
  reading.encoder_count = {12.0, 34.0};
  calibration.set_tare(reading, kSignature);
  calibration.set_zero(reading, {0.3, 0.35}, {-5.5, 7.25}, kSignature);
  ASSERT_TRUE(calibration.save(folder / "calibration.toml"));

  const auto loaded = Calibration::load(folder / "calibration.toml", "simulated");
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->text(), calibration.text());
  EXPECT_EQ(loaded->at(), "2026-03-01T12:00:00Z");
  EXPECT_EQ(loaded->by(), "Ada");
  const RigGeometry corrected = loaded->applied_to(RigGeometry{});
  EXPECT_EQ(corrected.force_offset_V, reading.volts);
  EXPECT_EQ(corrected.encoder_zero, (std::array<double, 2>{-5.5, 7.25}));
}

TEST(Calibration, PutsTheForceFitsOffsetInForceUntilTheNextTare) {
  Calibration calibration("simulated");
  ForceFit fit;
  fit.matrix << 4.0, 0.1, 0.2, 5.0;
  fit.offset = {0.5, 0.25};
  calibration.set_force(fit, kSignature);
  EXPECT_EQ(calibration.applied_to({}).force_offset_V, fit.offset);
  EXPECT_EQ(calibration.applied_to({}).force_calibration, fit.matrix);
  RestReading reading;
  reading.volts = {0.0625, 0.0};
  calibration.set_tare(reading, kSignature);
  EXPECT_EQ(calibration.applied_to({}).force_offset_V, reading.volts);
  EXPECT_EQ(calibration.applied_to({}).force_calibration, fit.matrix);
}

TEST(Calibration, RefusesThatOfAnotherDriverAndDamagedConstants) {
  const auto refusal = [](const std::string& text) {
    const auto parsed = Calibration::parse(text, "c.toml", "comedi");
    return parsed ? "accepted" : parsed.error().message;
  };
  EXPECT_EQ(refusal("driver = 'simulated'"),
            "c.toml:1: driver: \"simulated\" is not allowed; expected \"comedi\": give the rig another name, "
            "or remove the "
            "file");
  EXPECT_EQ(refusal("driver = 'comedi'\n[in_force]\nforce_offset_V = [1.0]"),
            "c.toml:3: in_force.force_offset_V: [1] is not allowed; expected two numbers");
  EXPECT_EQ(refusal("driver = 'comedi'\n[in_force]\nforce_calibration_N_per_V = [[1.0, 2.0]]"),
            "c.toml:3: in_force.force_calibration_N_per_V: [[1, 2]] is not allowed; expected two rows of two "
            "numbers");
  EXPECT_EQ(refusal("driver = 'comedi'\n[[load]]\nload_N = [1.0, 2.0]"),
            "c.toml: load[1] is not whole; expected load_N, force_V and sensor_angle_rad");
}

TEST(Calibration, TakesAsManyLoadsAsAMessageHoldsAndNoMore) {
  Calibration calibration("simulated");
  for (std::size_t i = 0; i < Calibration::kMostLoads; ++i)
    ASSERT_TRUE(calibration.add_load({{1.0, 2.0}, {0.1, 0.2}, 0.5}, kSignature));
  const auto more = calibration.add_load({{1.0, 2.0}, {0.1, 0.2}, 0.5}, kSignature);
  ASSERT_FALSE(more);
  EXPECT_EQ(more.error().message, "loads: 11 is not allowed; expected at most 10; begin again");
  calibration.forget_loads();
  EXPECT_TRUE(calibration.add_load({{1.0, 2.0}, {0.1, 0.2}, 0.5}, kSignature));
}

TEST(LoadReading, IsHeldByTheHandleWithTheOppositeForceInTheSensorsFrame) {
  // The sensor's x axis points along R's y: a pull along R's y is felt along its x, the other way round.
  const LoadReading reading{{0.0, 3.0}, {0.0, 0.0}, 1.5707963267948966};
  EXPECT_NEAR(reading.known_force().force.x(), -3.0, 1e-12);
  EXPECT_NEAR(reading.known_force().force.y(), 0.0, 1e-12);
}

}  // namespace
}  // namespace tonus::calibration
